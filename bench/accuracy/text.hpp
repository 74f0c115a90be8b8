#ifndef HFH_BENCH_ACCURACY_TEXT_HPP
#define HFH_BENCH_ACCURACY_TEXT_HPP

#include <cstdio>
#include <initializer_list>
#include <string>
#include <string_view>

namespace accuracy {

/// Numbers by printf's rules.
[[nodiscard]] std::string text(const char* format, auto... values) {
    char line[512];
    std::snprintf(line, sizeof line, format, values...);
    return line;
}

/// `pattern` with each {} replaced by the next of `values`.
[[nodiscard]] inline std::string filled(std::string_view pattern,
                                        std::initializer_list<std::string_view> values) {
    std::string out;
    for (const std::string_view value : values) {
        const auto hole = pattern.find("{}");
        out.append(pattern.substr(0, hole)).append(value);
        pattern.remove_prefix(hole + 2);
    }
    return out.append(pattern);
}

} // namespace accuracy

#endif // HFH_BENCH_ACCURACY_TEXT_HPP
