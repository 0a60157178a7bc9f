// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once

#include <cstring>

namespace talik {

/// exp(x) to two units in the last place for x <= 700; below -700 it stays at exp(-700), about 1e-304. Unlike the library's it
/// becomes part of the loop that it stands in, so that the compiler makes vectors of it.
[[gnu::always_inline]] inline double exponential(double x)
{
	// x = n ln 2 + r, |r| <= ln(2)/2; ln 2 in two parts so that r keeps its digits; exp(r) by its series
	constexpr double inverseLn2 = 1.4426950408889634074, high = 6.93147180369123816490e-01, low = 1.90821492927058770002e-10;
	constexpr double toInteger = 6755399441055744.0; // 1.5 2^52: adding it rounds to the nearest integer
	const double     bounded   = x < -700.0 ? -700.0 : x;
	const double     shifted   = bounded * inverseLn2 + toInteger;
	const double     n         = shifted - toInteger;
	const double     r         = (bounded - n * high) - n * low;
	double           p         = 1.0 / 6227020800.0;
	p                          = p * r + 1.0 / 479001600.0;
	p                          = p * r + 1.0 / 39916800.0;
	p                          = p * r + 1.0 / 3628800.0;
	p                          = p * r + 1.0 / 362880.0;
	p                          = p * r + 1.0 / 40320.0;
	p                          = p * r + 1.0 / 5040.0;
	p                          = p * r + 1.0 / 720.0;
	p                          = p * r + 1.0 / 120.0;
	p                          = p * r + 1.0 / 24.0;
	p                          = p * r + 1.0 / 6.0;
	p                          = p * r + 0.5;
	p                          = p * r * r + r + 1.0;
	// the integer sits in the last bits of the shifted number: move it to the exponent
	unsigned long long bits;
	std::memcpy(&bits, &shifted, sizeof bits);
	const unsigned long long power = (bits + 1023u) << 52;
	double                   scale;
	std::memcpy(&scale, &power, sizeof scale);
	return p * scale;
}

} // namespace talik
