// Memory asked for ahead: by addresses alone, whatever has become of what was there.
#include "Fetch.hpp"

#include <catch2/catch_test_macros.hpp>

#include <memory>

using namespace softgrain;

TEST_CASE("memory that is gone may be asked for", "[fetch]")
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
