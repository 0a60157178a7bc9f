// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
#include <core/Scene.hpp>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace talik {

/// First part of a checkpoint, plain text of fixed length; the scene follows in YADE's binary archive.
struct CheckpointHeader {
	int                                format   = 0;
	std::uint64_t                      bytes    = 0; ///< of the scene
	std::uint64_t                      checksum = 0; ///< CRC-64 of these bytes
	long                               step     = 0; ///< steps done
	double                             time     = 0; ///< of the scene [s]
	std::string                        written;      ///< date, UTC
	std::map<std::string, std::string> classes;      ///< digest of each class's attributes
};

/// Names of the classes whose attributes a checkpoint depends on beside those of stock YADE; set when they are registered.
std::vector<std::string>& checkpointClasses();

/// Writes a scene beside `file` and renames it when it is on the disk whole: whatever happens, `file` is the former checkpoint or the
/// new one. A missing folder is made. Throws std::runtime_error that names file and cause; nothing is left of a failed attempt.
void writeCheckpoint(const std::string& file, const boost::shared_ptr<yade::Scene>& scene);

/// Throws std::invalid_argument naming the file and what may be done when a checkpoint cannot be written there.
void requireWritable(const std::string& file);

/// Header of a checkpoint that is whole. Throws std::invalid_argument for a missing, foreign, truncated or damaged file and for one of
/// another format.
CheckpointHeader inspectCheckpoint(const std::string& file);

/// The scene of a checkpoint; a written by an older version is read if the classes it holds have kept their attributes, else refused
/// by naming them. Throws as inspectCheckpoint().
boost::shared_ptr<yade::Scene> readCheckpoint(const std::string& file);

} // namespace talik
