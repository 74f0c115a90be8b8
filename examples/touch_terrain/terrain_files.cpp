#include "terrain_files.hpp"

#include "bad_input.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace demo {
namespace {

namespace fs = std::filesystem;

/// Appends the files in the directory of `terrain` that have its name, with another ending or one more.
void append_beside(const fs::path& terrain, std::vector<fs::path>& files) {
    constexpr std::array<std::string_view, 11> endings{".hdr", ".prj", ".xml", ".aux", ".clr", ".stx",
                                                       ".tfw", ".pgw", ".wld", ".ovr", ".msk"};
    const std::string stem = terrain.stem().string();
    const fs::path folder = terrain.has_parent_path() ? terrain.parent_path() : ".";
    std::error_code error;
    for (auto at = fs::directory_iterator{folder, error}; !error && at != fs::directory_iterator{};
         at.increment(error)) {
        const std::string name = at->path().filename().string();
        if (!name.starts_with(stem + '.')) continue;
        std::string ending = at->path().extension().string();
        for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (std::ranges::find(endings, ending) != endings.end()) files.push_back(at->path());
    }
}

/// True if `output` is `file` or, where that is a directory, lies in it.
bool takes_place_of(const fs::path& output, const fs::path& file) {
    std::error_code error;
    if (fs::equivalent(output, file, error)) return true;
    if (!fs::is_directory(file, error)) return false;
    for (fs::path folder = fs::canonical(output, error); folder.has_relative_path();
         folder = folder.parent_path()) {
        if (fs::equivalent(folder, file, error)) return true;
    }
    return false;
}

} // namespace

bool is_same_file(const fs::path& a, const fs::path& b) {
    std::error_code error;
    if (fs::equivalent(a, b, error)) return true;
    const fs::path first = fs::weakly_canonical(a, error);
    return !first.empty() && first == fs::weakly_canonical(b, error);
}

void refuse_to_replace_terrain(const fs::path& terrain, const char* option, const fs::path& output) {
    std::error_code error;
    if (!fs::exists(output, error)) return;
    std::vector<fs::path> files{terrain};
    if (fs::exists(terrain, error)) {
        append_beside(terrain, files);
        append_beside(fs::canonical(terrain, error), files);
    }
#ifdef TOUCH_TERRAIN_HAS_GDAL
    std::ranges::move(files_with_gdal(terrain.string()), std::back_inserter(files));
#endif
    if (std::ranges::none_of(files, [&](const fs::path& file) { return takes_place_of(output, file); }))
        return;
    throw BadInput{std::string{option} + " " + output.string() + " is there and belongs to the terrain " +
                   terrain.string() + ": it is not written over."};
}

} // namespace demo
