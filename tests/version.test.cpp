#include <hfh/version.hpp>

#include "catch.hpp"

#include <string>

TEST_CASE("version: is the version that CMake read from the header") {
    const std::string from_header = std::to_string(HFH_VERSION_MAJOR) + '.' +
                                    std::to_string(HFH_VERSION_MINOR) + '.' +
                                    std::to_string(HFH_VERSION_PATCH);
    REQUIRE(from_header == HFH_PROJECT_VERSION);
}
