// Memory asked for ahead: by addresses alone, whatever has become of what was there.
#include "Fetch.hpp"

#include <catch2/catch_test_macros.hpp>

#include <memory>

using namespace softgrain;

TEST_CASE("lines of memory hold all of what is asked for", "[fetch]")
{
	alignas(cacheLine) const char bytes[4 * cacheLine] = {};
	CHECK(linesOf(bytes, bytes) == 0);
	CHECK(linesOf(bytes, bytes + 1) == 1);
	CHECK(linesOf(bytes, bytes + cacheLine) == 1);
	CHECK(linesOf(bytes, bytes + cacheLine + 1) == 2);
	CHECK(linesOf(bytes + cacheLine - 1, bytes + cacheLine + 1) == 2);
	CHECK(lineOf(bytes + cacheLine) == lineOf(bytes) + 1);
}

/// What was asked for shows nowhere: it ends, or it does not.
TEST_CASE("smoke test: memory that is gone may be asked for", "[fetch]")
{
	LoopMemory memory;
	memory.beginRun(2);
	auto gone = std::make_unique<std::vector<double>>(1 << 20);
	MemoryPieces read;
	read.add(*gone);
	for (int k = 0; k < 2 * MemoryPieces::most; ++k)
		read.add(*gone->data());
	memory.note(1, read);
	gone.reset();
	memory.beginRun(1);
	memory.fetch(1);

	SECTION("and turns there are none of, too")
	{
		memory.note(1, read);
		memory.note(static_cast<std::size_t>(-1), read);
		memory.fetch(2);
		memory.fetch(static_cast<std::size_t>(-1));
	}
	SUCCEED();
}
