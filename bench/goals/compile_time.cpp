#include "strokes.hpp"

#include <sys/resource.h>

#include <cstdlib>
#include <set>
#include <sstream>

// #include <hfh/hfh.hpp> against the headers of GLM that it includes, compiled in turn.

namespace hfh::bench {
namespace {

/// Adds to `glm` what <hfh/…> headers include of GLM, `name` and those it includes.
void glm_headers(const std::string& include, const std::string& name, std::set<std::string>& seen,
                 std::set<std::string>& glm) {
    if (!seen.insert(name).second) return;
    std::ifstream file{include + "/" + name};
    if (!file) throw std::runtime_error{"cannot read " + name};
    for (std::string line; std::getline(file, line);) {
        if (!line.starts_with("#include <")) continue;
        const std::string header = line.substr(10, line.find('>') - 10);
        if (header.starts_with("hfh/")) glm_headers(include, header, seen, glm);
        if (header.starts_with("glm/")) glm.insert(header);
    }
}

double seconds_of_children() {
    rusage used{};
    getrusage(RUSAGE_CHILDREN, &used);
    // The sum is exact; how Linux splits it is told by ticks of some milliseconds.
    return static_cast<double>(used.ru_utime.tv_sec + used.ru_stime.tv_sec) +
           1e-6 * static_cast<double>(used.ru_utime.tv_usec + used.ru_stime.tv_usec);
}

} // namespace

Findings compile_time(const Settings& settings) {
    std::set<std::string> seen, glm;
    glm_headers(settings.include, "hfh/hfh.hpp", seen, glm);
    const std::string ours = settings.scratch + "/include_hfh.cpp",
                      theirs = settings.scratch + "/include_glm.cpp";
    std::ofstream{ours} << "#include <hfh/hfh.hpp>\n";
    std::string list;
    {
        std::ofstream file{theirs};
        for (const auto& header : glm) {
            file << "#include <" << header << ">\n";
            list += (list.empty() ? "" : " ") + header;
        }
    }
    std::string flags = " -std=c++20 -O3 -I" + settings.include;
    if (!settings.glm_include.empty()) flags += " -isystem " + settings.glm_include;
    const auto compile = [&](const std::string& source) {
        const double before = seconds_of_children();
        const std::string command = settings.compiler + flags + " -c " + source + " -o " + source + ".o";
        if (std::system(command.c_str()) != 0) throw Fault{"does not compile: " + source};
        return seconds_of_children() - before;
    };
    double of_hfh = 1e9, of_glm = 1e9;
    for (int round = 0; round < 5; ++round) {
        of_hfh = std::min(of_hfh, compile(ours));
        of_glm = std::min(of_glm, compile(theirs));
    }
    Findings found;
    found.numbers.push_back(
        {"compile_time", "", of_hfh / of_glm, {1e9 * of_glm, 1e9 * of_hfh}, "GLM: " + list});
    return found;
}

} // namespace hfh::bench
