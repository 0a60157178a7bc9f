// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/BodyContainer.hpp>
#include <core/Interaction.hpp>
#include <mutex>

namespace yade {
class InteractionContainer : public Serializable {
	using ContainerT = vector<shared_ptr<Interaction>>;
	ContainerT                       linIntrs;
	ContainerT                       sortedIntrs;
	const BodyContainer::ContainerT* bodies;
	size_t                           currSize;
	shared_ptr<Interaction>          empty;
	ContainerT                       interaction;

public:
	bool       dirty;
	std::mutex drawloopmutex;
	bool       serializeSorted;
	long       iterColliderLastRun;

	virtual ~InteractionContainer();
	string                getBaseClassName(unsigned int = 0) const override;
	int                   getBaseClassNumber() const override;
	string                getClassName() const override;
	void                  pySetAttr(const std::string&, const ::boost::python::object&) override;
	::boost::python::dict pyDict() const override;
	void                  callPostLoad() override;

	using iterator = ContainerT::iterator;
	iterator                       begin() { return linIntrs.begin(); }
	iterator                       end() { return linIntrs.end(); }
	size_t                         size() { return currSize; }
	void                           clear();
	bool                           insert(const shared_ptr<Interaction>&);
	bool                           erase(Body::id_t, Body::id_t, int linPos = -1);
	const shared_ptr<Interaction>& find(Body::id_t, Body::id_t);

private:
	InteractionContainer();
	friend struct InteractionContainerLayout;
};
} // namespace yade
