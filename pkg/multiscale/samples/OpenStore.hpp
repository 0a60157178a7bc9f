// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/rve/open/OpenSample.hpp>
#include <pkg/rve/open/ScenePacking.hpp>

namespace talik {

/// Samples in the open form: a Scene behind each point, its own from the moment when the sample is asked for the first time.
template <int Dim> class OpenStore final : public SampleStoreOf<Dim> {
public:
	/// Scenes as bytes (sceneToBytes). Throws std::invalid_argument naming the scene that cannot be a sample.
	explicit OpenStore(const std::vector<std::string>& prototypes);

	int                     prototypeCount() const override { return int(prototypes.size()); }
	double                  prototypeIce(int prototype) const override { return prototypes.at(prototype)->iceSaturation(); }
	double                  oedometricModulus(int prototype, double iceSaturation) const override { return stiffness.at(prototype).modulus(iceSaturation); }
	const SampleStart<Dim>& add(int prototype, double iceSaturation, const PackedUpdateOptions&) override;
	void                    copy(std::size_t sample) override { samples.push_back(samples.at(sample)); }
	void                    release(std::size_t sample) override { samples.at(sample) = prototypes.front(); }
	std::size_t             size() const override { return samples.size(); }
	void                    clear() override { samples.clear(); }
	std::vector<PackedUpdateResult<Dim>> update(const std::vector<PackedRequest<Dim>>&, const PackedUpdateOptions&, int threads) override;
	bool                                 comparesRates() const override { return false; }
	const void*                          identity(std::size_t sample) const override { return samples.at(sample).get(); }
	std::size_t                          bytes() const override; ///< of the archived states; a Scene holds about a megabyte more
	double                               costOfStep(std::size_t) const override { return 1; }
	void                                 saveState(ByteWriter&, std::size_t sample) const override;
	void                                 restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	void                                 resize(std::size_t count) override { samples.assign(count, prototypes.front()); }

	/// A copy of the scene behind a point.
	boost::shared_ptr<yade::Scene> scene(std::size_t sample) const { return sceneForView(sceneToBytes(samples.at(sample)->yadeScene())); }
	void                           setScene(std::size_t sample, const boost::shared_ptr<yade::Scene>&);

protected:
	std::vector<double> measureHere(std::size_t sample, const std::string& name) const override;

private:
	using Pointer = std::shared_ptr<OpenSample>; ///< of one sample, or of several that were not asked since they were prepared
	struct Beginning {
		Pointer          sample;
		SampleStart<Dim> start;
	};
	void prepare(const std::vector<PackedRequest<Dim>>&);

	std::vector<Pointer>                        prototypes, samples;
	std::vector<StiffnessBound>                 stiffness; ///< of each prototype
	std::map<std::pair<int, double>, Beginning> beginnings;
};

} // namespace talik
