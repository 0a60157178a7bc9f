// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <map>
#include <pkg/multiscale/samples/SampleStore.hpp>

namespace talik {

/// Samples in the packed form.
template <int Dim> class PackedStore : public SampleStoreOf<Dim> {
public:
	using StatePointer = std::shared_ptr<const PackedState<Dim>>;
	explicit PackedStore(std::vector<StatePointer> prototypes);

	int                                  prototypeCount() const override { return int(prototypes.size()); }
	double                               prototypeIce(int prototype) const override { return prototypes.at(prototype)->iceSaturation; }
	double                               oedometricModulus(int prototype, double iceSaturation) const override;
	const SampleStart<Dim>&              add(int prototype, double iceSaturation, const PackedUpdateOptions&) override;
	void                                 copy(std::size_t sample) override { pool.add(pool.compact(sample)); }
	void                                 release(std::size_t sample) override { pool.share(sample, beginnings.begin()->second.sample); }
	std::size_t                          size() const override { return pool.size(); }
	void                                 clear() override { pool.clear(); }
	std::vector<PackedUpdateResult<Dim>> update(const std::vector<PackedRequest<Dim>>&, const PackedUpdateOptions&, int threads) override;
	bool                                 comparesRates() const override { return true; }
	const void*                          identity(std::size_t sample) const override { return pool.compact(sample).get(); }
	std::size_t                          distinctStates() const override { return pool.distinctStates(); } ///< asks no device
	std::size_t                          bytes() const override { return pool.bytes(); }
	double                               costOfStep(std::size_t sample) const override { return double(pool.bytes(sample)); }
	void                                 saveState(ByteWriter&, std::size_t sample) const override;
	void                                 restoreState(ByteReader&, const std::vector<std::size_t>& samples) override;
	void                                 resize(std::size_t samples) override;

	/// See SamplePool.
	void useDevice(std::shared_ptr<SampleDevice> device, std::function<void(const std::string&)> say) { pool.useDevice(std::move(device), std::move(say)); }
	DeviceUse deviceUse() const { return pool.deviceUse(); }

	StatePointer state(std::size_t sample) const { return std::make_shared<const PackedState<Dim>>(pool.state(sample)); }
	void         setState(std::size_t sample, StatePointer state) { pool.setState(sample, *state); }

protected:
	std::vector<double> measureHere(std::size_t sample, const std::string& name) const override;

private:
	struct Beginning {
		typename SamplePool<Dim>::Compact sample;
		SampleStart<Dim>                  start;
	};
	Beginning frozen(int prototype, double iceSaturation, const PackedUpdateOptions&) const;

	std::vector<StatePointer> prototypes;
	std::vector<double>       meanRadius; ///< of each prototype [m]
	/// Constants of preparations that restored samples take, those of the prototypes first.
	std::vector<std::shared_ptr<const PackedGrains>> knownGrains;
	std::map<std::pair<int, double>, Beginning>      beginnings;
	SamplePool<Dim>                                  pool;
};

} // namespace talik
