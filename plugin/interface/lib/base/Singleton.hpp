// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
/// Defined by libyade: never instantiate it here.
template <class T> class Singleton {
protected:
	static T* self;

public:
	static T& instance();
};
