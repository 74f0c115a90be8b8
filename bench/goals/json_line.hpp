#ifndef HFH_BENCH_GOALS_JSON_LINE_HPP
#define HFH_BENCH_GOALS_JSON_LINE_HPP

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

namespace hfh::bench {

/// One JSON object a line.
class JsonLine {
public:
    JsonLine& add(const char* key, const std::string& plain) {
        begin(key);
        text_ += '"';
        for (const char c : plain) {
            if (c == '"' || c == '\\') text_ += '\\';
            text_ += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
        text_ += '"';
        return *this;
    }
    JsonLine& add(const char* key, double number) {
        begin(key);
        append(number);
        return *this;
    }
    JsonLine& add(const char* key, const std::vector<double>& numbers) {
        begin(key);
        text_ += '[';
        for (const double& n : numbers) {
            if (&n != numbers.data()) text_ += ", ";
            append(n);
        }
        text_ += ']';
        return *this;
    }
    /// To standard output.
    void print() const { std::printf("%s}\n", text_.c_str()); }

private:
    void begin(const char* key) {
        text_ += text_.empty() ? "{\"" : ", \"";
        text_ += key;
        text_ += "\": ";
    }
    /// JSON has no infinity and no NaN.
    void append(double number) {
        char digits[32];
        std::snprintf(digits, sizeof digits, "%.6g", number);
        text_ += std::isfinite(number) ? digits : "null";
    }

    std::string text_;
};

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_JSON_LINE_HPP
