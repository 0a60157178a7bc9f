// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
namespace yade {
/// Dispatch index of a class. In the five classes that inherit it the order of the overriders is part of the binary
/// interface: they take slots of the primary table, too.
class Indexable {
protected:
	void         createIndex();
	virtual void incrementMaxCurrentlyUsedClassIndexOfKin();
	virtual int& modifyClassIndex();

public:
	Indexable() {}
	virtual ~Indexable();
	virtual const int& getClassIndex() const;
	virtual const int& getBaseClassIndex(int) const;
	virtual const int& getMaxCurrentlyUsedClassIndexOfKin() const;
};
} // namespace yade

/// Declarations of a top-level indexable class of stock YADE.
#define TALIK_STOCK_INDEX_COUNTER()                                     \
protected:                                                              \
	int& modifyClassIndex() override;                               \
                                                                        \
public:                                                                 \
	const int& getClassIndex() const override;                      \
	const int& getBaseClassIndex(int) const override;               \
	const int& getMaxCurrentlyUsedClassIndexOfKin() const override; \
                                                                        \
protected:                                                              \
	void incrementMaxCurrentlyUsedClassIndexOfKin() override;       \
                                                                        \
public:

/// Declarations of a derived indexable class of stock YADE.
#define TALIK_STOCK_INDEX()                        \
protected:                                         \
	int& modifyClassIndex() override;          \
                                                   \
public:                                            \
	const int& getClassIndex() const override; \
	const int& getBaseClassIndex(int) const override;

/// Index of a class of ours.
#define REGISTER_CLASS_INDEX(Class, Base)                                            \
	static int& ownClassIndex()                                                  \
	{                                                                            \
		static int index = -1;                                               \
		return index;                                                        \
	}                                                                            \
                                                                                     \
protected:                                                                           \
	int& modifyClassIndex() override { return ownClassIndex(); }                 \
                                                                                     \
public:                                                                              \
	static const int& getClassIndexStatic() { return ownClassIndex(); }          \
	const int&        getClassIndex() const override { return ownClassIndex(); } \
	const int&        getBaseClassIndex(int depth) const override { return depth == 1 ? Base::getClassIndex() : Base::getBaseClassIndex(depth - 1); }
