// Compressed sparse rows: the storage of every table of the reference configuration.
#pragma once

#include <vector>

namespace softgrain {

/// Row r holds the entries `begin(r) .. end(r)`: `column[k]` with `value[k]`.
template <class Value> struct SparseRows {
	std::vector<int> offset { 0 };
	std::vector<int> column;
	std::vector<Value> value;

	int rows() const { return static_cast<int>(offset.size()) - 1; }
	int begin(int row) const { return offset[row]; }
	int end(int row) const { return offset[row + 1]; }

	void append(int col, const Value& v)
	{
		column.push_back(col);
		value.push_back(v);
	}
	void closeRow() { offset.push_back(static_cast<int>(column.size())); }
};

} // namespace softgrain
