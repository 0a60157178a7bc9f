// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <functional>
#include <lib/serialization/Serializable.hpp>

namespace yade {

/// Histories of a few material points: rows of numbers, one per watched point and instant.
class PointWatch : public Serializable {
public:
	/// Numbers of a field at a point, by id.
	using Look = std::function<vector<Real>(const string& field, int id)>;
	virtual ~PointWatch() {};

	bool isDue(Real time) const { return times.empty() || (time > times.back() && time >= next); }
	void record(Real time, const Look&);
	/// Dictionary of NumPy arrays by instant: time and the fields of one watched point. Throws std::invalid_argument for others.
	::boost::python::dict history(int id) const;

	// clang-format off
	YADE_CLASS_BASE_DOC_ATTRS(PointWatch,Serializable,"What MpmEngine.watch() records of a few material points; see MpmEngine.history(). Example: "
			"mpm.watch([0],interval=0.01); mpm.history(0)['time'].",
		((vector<int>,ids,,Attr::readonly,"Watched points."))
		((Real,interval,0,Attr::readonly,"Time between two records [s]; 0: every step."))
		((vector<string>,fields,,Attr::readonly,"Recorded fields."))
		((vector<Real>,times,,Attr::readonly,"Instants of the records [s]."))
		((Real,next,0,Attr::hidden,"Earliest instant of the next record [s]."))
		((vector<int>,components,,Attr::hidden,"Numbers of each field."))
		((vector<Real>,rows,,Attr::hidden,"The records: by instant, watched point, field, component."))
	);
	// clang-format on
};
REGISTER_SERIALIZABLE(PointWatch);

} // namespace yade
