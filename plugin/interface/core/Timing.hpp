// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
namespace yade {
struct TimingInfo {
	long               nExec;
	unsigned long long nsec;
};
class TimingDeltas;
} // namespace yade
