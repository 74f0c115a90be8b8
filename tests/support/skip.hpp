#ifndef HFH_TESTS_SUPPORT_SKIP_HPP
#define HFH_TESTS_SUPPORT_SKIP_HPP

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>

namespace hfh::test {

/// Says that a test case has nothing to test here, and why. CTest takes the line for the result, even of a test that failed
/// (SKIP_REGULAR_EXPRESSION in tests/CMakeLists.txt), so a test case says it before it checks anything, and returns.
inline void skip(const std::string& why) {
    std::printf("hfh: skipped: %s\n", why.c_str());
    std::fflush(stdout);
}

/// The path of a file of HFH_SHARED_DATA_DIR; none, and says that the test is skipped, if it is not there.
[[nodiscard]] inline std::optional<std::string> shared_file_or_skip(const std::string& name) {
    const std::string path = HFH_SHARED_DATA_DIR "/" + name;
    if (std::filesystem::exists(path)) return path;
    skip(path + " is not there");
    return {};
}

[[nodiscard]] inline bool has_program(const std::string& name) {
    return std::system(("command -v " + name + " >/dev/null 2>&1").c_str()) == 0;
}

/// Whether a program can be called; if not, says that the test is skipped.
[[nodiscard]] inline bool has_program_or_skip(const std::string& name) {
    const bool found = has_program(name);
    if (!found) skip(name + " is not installed");
    return found;
}

} // namespace hfh::test

#endif // HFH_TESTS_SUPPORT_SKIP_HPP
