// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace talik {

class AnyGround;

/// What a 3-D view draws of a ground. A view asks for it and a step takes it as it ends, so that neither waits for the other: views are
/// drawn under a lock that calls from Python may want.
class GroundPicture {
public:
	struct Points {
		int                 dimension = 2;
		std::vector<double> position[3]; ///< by id [m]; in the plane two
		std::vector<double> edge;        ///< of a square or cube of the volume of the point [m]
		std::vector<double> value;       ///< of the field, of several components their norm; empty if there is no such field
	};

	/// From any thread: the next step to end takes a picture of this field.
	void ask(const std::string& field);
	/// Between two steps; does nothing unless a view asked.
	void takeIfAsked(const AnyGround& ground, int pointCount);
	/// The last one taken, from any thread; null before the first.
	std::shared_ptr<const Points> last() const;

private:
	mutable std::mutex            mutex;
	std::atomic<bool>             asked { false };
	std::string                   field;
	std::shared_ptr<const Points> taken;
};

} // namespace talik
