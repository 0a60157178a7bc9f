// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <pkg/base/SavedBytes.hpp>
#include <pkg/ranks/PartedFile.hpp>
#include <pkg/rve/packed/PackedSamplePool.hpp>
#include <string>
#include <vector>

namespace talik {

/// What a sample that was never asked begins with.
template <int Dim> struct SampleStart {
	typename PackedTypes<Dim>::Matrix stress = PackedTypes<Dim>::Matrix::Zero(); ///< symmetrised, tension positive [Pa]
	PackedTangent<Dim>                tangent {};
};

/// The samples behind the points of a skeleton, in one of their forms. Samples are made from prototypes; both are numbered from 0.
class SampleStore {
public:
	virtual ~SampleStore() = default;

	virtual int    prototypeCount() const                                       = 0;
	virtual double prototypeIce(int prototype) const                            = 0; ///< ice saturation it was prepared with [-]
	virtual double oedometricModulus(int prototype, double iceSaturation) const = 0; ///< upper bound [Pa]

	/// A new sample in the state of another.
	virtual void copy(std::size_t sample) = 0;
	/// The sample of a point that has left, or that another rank owns: its memory goes, its number stays.
	virtual void        release(std::size_t sample) = 0;
	virtual std::size_t size() const                = 0;
	virtual void        clear()                     = 0;

	/// Whether requests may compare rates.
	virtual bool comparesRates() const = 0;

	/// A named measure; several numbers for tensors. Throws std::invalid_argument on an unknown name.
	std::vector<double> measure(std::size_t sample, const std::string& name) const
	{
		bring(sample);
		return measureHere(sample, name);
	}
	/// That of all samples; those that share a state are measured once.
	std::vector<std::vector<double>> measureAll(const std::string& name) const;
	/// The same for samples that share one state.
	virtual const void* identity(std::size_t sample) const = 0;
	virtual std::size_t distinctStates() const { return survey("").firstOf.size(); }
	virtual std::size_t bytes() const = 0;
	/// Of one DEM step of a sample, in a unit of the store's own: samples are shared out by it.
	virtual double costOfStep(std::size_t sample) const = 0;

	/// How all samples are saved, each state once: states in the order of the first sample that has each.
	struct Layout {
		std::vector<std::uint64_t> stateOf, lengths; ///< number of each sample's state, and bytes of each state
		std::uint64_t              bytes() const;
		std::vector<std::size_t>   firstOf() const;
		void                       save(ByteWriter&) const;
		static Layout              from(ByteReader&);
	};
	Layout layout() const;
	/// Returns what the states add to the sum of the file. Where ranks own samples each writes its own; one rank may call it.
	virtual std::uint64_t writeStates(const Layout&, const FilePlace&) const;
	/// Those of whose first sample this is true.
	void writeStates(const Layout&, const FilePlace&, PartSum&, const std::function<bool(std::size_t sample)>& writes) const;
	/// The states one after the other, in this process.
	std::string states() const;
	/// bytes(at, length): of the states; each rank reads what it owns.
	void restore(const Layout&, const std::function<std::string(std::uint64_t at, std::uint64_t length)>& bytes);
	/// The state of one sample as it is in this process, and back as that of several which share it.
	virtual void saveState(ByteWriter&, std::size_t sample) const                   = 0;
	virtual void restoreState(ByteReader&, const std::vector<std::size_t>& samples) = 0;
	/// So many samples, whose states are restored next.
	virtual void resize(std::size_t samples) = 0;

	/// Where other ranks own samples: before the state of one is read, and after it was replaced, on all ranks by the same.
	virtual void bring(std::size_t) const {}
	/// Waits for ranks that look at it alone: they see it as it was.
	virtual void beforeReplacing(std::size_t) {}
	virtual void replaced(std::size_t) {}
	/// How the samples are shared out among the ranks; nothing where they are not.
	struct Sharing {
		std::uint64_t samples = 0; ///< whose state this rank owns
		std::uint64_t moved   = 0; ///< states that were given to another rank since the start
		double        balance = 1; ///< mean over largest cost of the ranks, summed over updates [-]
	};
	virtual const Sharing* sharing() const { return nullptr; }

protected:
	/// Whether restoreState() needs the state of samples that share it.
	virtual bool wants(const std::vector<std::size_t>&) const { return true; }
	/// The states of all samples, in the order of the first sample that has each, and what their owners say to a question: "state" (its bytes),
	/// "length" (how many), "measure <name>" (its numbers) or nothing. All that saves, measures or counts samples begins with it.
	struct Survey {
		std::vector<std::size_t> stateOf, firstOf; ///< number of each sample's state, and the first sample that has each state
		std::vector<std::string> answers;          ///< of each state; empty where it is in this process
	};
	virtual Survey survey(const std::string& question) const;
	/// What a sample that is in this process says to such a question.
	std::string answer(const std::string& question, std::size_t sample) const;
	/// Of a sample as it is in this process.
	virtual std::vector<double> measureHere(std::size_t sample, const std::string& name) const = 0;

private:
	std::string said(const Survey&, const std::string& question, std::size_t state) const;
};

/// The same of discs (Dim 2) or spheres (Dim 3).
template <int Dim> class SampleStoreOf : public SampleStore {
public:
	/// A new sample: a prototype frozen at rest, free of stress, to an ice saturation. Samples that begin alike share their beginning,
	/// which stays valid until the next add(). Throws std::runtime_error if the prototype does not survive freezing.
	virtual const SampleStart<Dim>& add(int prototype, double iceSaturation, const PackedUpdateOptions&) = 0;
	/// Each request's sample, at most once per call, over `threads` threads (0: OpenMP's default) with results that do not depend on
	/// their number. A sample that blows up keeps a good state.
	virtual std::vector<PackedUpdateResult<Dim>> update(const std::vector<PackedRequest<Dim>>&, const PackedUpdateOptions&, int threads) = 0;
};

/// Components of a fabric, stress or strain in the order in which samples give them: xx yy xy, in space xx yy zz yz xz xy.
template <int Dim> std::vector<double> components(const typename PackedTypes<Dim>::Matrix& m)
{
	if constexpr (Dim == 2) return { m(0, 0), m(1, 1), 0.5 * (m(0, 1) + m(1, 0)) };
	else return { m(0, 0), m(1, 1), m(2, 2), 0.5 * (m(1, 2) + m(2, 1)), 0.5 * (m(0, 2) + m(2, 0)), 0.5 * (m(0, 1) + m(1, 0)) };
}

/// "…; choose bondsIntact, …", for exceptions.
[[noreturn]] void refuseMeasure(const std::string& name);

/// One of the measures that follow from the statistics of a sample. Throws std::invalid_argument on another name.
template <int Dim, class Statistics> std::vector<double> measureFrom(const Statistics& s, const std::string& name)
{
	if (name == "bondsIntact") return { double(s.bondsIntact) };
	if (name == "contacts") return { double(s.contacts) };
	if (name == "coordinationNumber") return { s.coordinationNumber };
	if (name == "samplePorosity") return { s.porosity };
	if (name == "cellThickness") return { s.cellThickness };
	if (name != "fabric") refuseMeasure(name);
	return components<Dim>(s.fabric.template topLeftCorner<Dim, Dim>());
}

/// Names of what every store measures.
const std::vector<std::string>& sampleMeasures();

} // namespace talik
