// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/multiscale/samples/SampleStore.hpp>
#include <pkg/rve/open/OpenSample.hpp>

namespace talik {

/// Samples in the open form: a Scene of its own behind each point, made when the sample is asked for the first time.
template <int Dim> class OpenStore final : public SampleStoreOf<Dim> {
public:
	/// Scenes as bytes (sceneToBytes). Throws std::invalid_argument naming the scene that cannot be a sample.
	explicit OpenStore(const std::vector<std::string>& prototypes);

	int    prototypeCount() const override { return int(prototypes.size()); }
	double prototypeIce(int prototype) const override { return prototypes.at(prototype)->iceSaturation; }
	double oedometricModulus(int prototype, double iceSaturation) const override { return prototypes.at(prototype)->stiffness.modulus(iceSaturation); }
	const SampleStart<Dim>&              add(int prototype, double iceSaturation, const PackedUpdateOptions&) override;
	void                                 release(std::size_t sample) override { at(sample) = Sample { prototypes.front(), nullptr }; }
	std::size_t                          size() const override { return samples.size(); }
	void                                 clear() override { samples.clear(); }
	std::vector<PackedUpdateResult<Dim>> update(const std::vector<PackedRequest<Dim>>&, const PackedUpdateOptions&, int threads) override;
	bool                                 comparesRates() const override { return false; }
	std::vector<double>                  measure(std::size_t sample, const std::string& name) const override;
	const void*                          identity(std::size_t sample) const override;
	std::size_t                          bytes() const override; ///< of the archived states; a running Scene holds about a megabyte more
	double                               costOfStep(std::size_t) const override;
	void                                 saveState(ByteWriter&, std::size_t sample) const override;
	void                                 restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	void                                 resize(std::size_t samples) override;

	/// A copy of the scene behind a point.
	boost::shared_ptr<yade::Scene> scene(std::size_t sample) const;
	void                           setScene(std::size_t sample, const boost::shared_ptr<yade::Scene>&);

private:
	/// A state that samples share until they are asked.
	struct Beginning {
		std::string                  scene;
		std::array<std::uint64_t, 2> bondCounts {};
		double                       iceSaturation = 0;
		bool                         hasIce        = false;
		SampleStart<Dim>             start;
		OpenStatistics               statistics;
		StiffnessBound               stiffness;
		OpenSample                   makeSample() const;
	};
	using BeginningPointer = std::shared_ptr<const Beginning>;
	struct Sample {
		BeginningPointer            beginning;
		std::unique_ptr<OpenSample> running;
	};
	static BeginningPointer describe(OpenSample&);
	BeginningPointer        frozen(int prototype, double iceSaturation, const PackedUpdateOptions&) const;
	void                    prepare(const std::vector<PackedRequest<Dim>>&);
	Sample&                 at(std::size_t sample);
	const Sample&           at(std::size_t sample) const;

	std::vector<BeginningPointer>                      prototypes;
	std::map<std::pair<int, double>, BeginningPointer> beginnings;
	std::vector<Sample>                                samples;
};

} // namespace talik
