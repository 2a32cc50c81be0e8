// An optional value that few have: it lies elsewhere in memory, and who has none pays a pointer.
// Else used as std::optional.
#pragma once

#include <memory>

namespace softgrain {

template <class T> class Rare {
public:
	Rare() = default;
	Rare(Rare&&) = default;
	Rare(const Rare& other)
		: value_(other ? std::make_unique<T>(*other) : nullptr)
	{
	}
	Rare& operator=(Rare other)
	{
		value_.swap(other.value_);
		return *this;
	}
	/// A new value, in place of one that may be there.
	T& emplace()
	{
		if (value_)
			*value_ = T();
		else
			value_ = std::make_unique<T>();
		return *value_;
	}
	void reset() { value_.reset(); }

	explicit operator bool() const { return value_ != nullptr; }
	bool has_value() const { return value_ != nullptr; }
	T& operator*() { return *value_; }
	const T& operator*() const { return *value_; }
	T* operator->() { return value_.get(); }
	const T* operator->() const { return value_.get(); }

private:
	std::unique_ptr<T> value_;
};

} // namespace softgrain
