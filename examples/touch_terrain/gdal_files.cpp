#include "gdal_dataset.hpp"
#include "terrain_files.hpp"

#include <cpl_minixml.h>

#include <array>
#include <cstring>
#include <optional>
#include <set>
#include <string_view>

namespace demo {
namespace {

namespace fs = std::filesystem;

/// The file that `name` is, or that stands in it, as the archive in /vsizip/dir/a.zip/b.tif and the database in
/// GPKG:"a.gpkg":layer: the longest piece that is a file, of those that begin first. Relative paths start here or in `folder`.
std::optional<fs::path> file_in(const std::string& name, const fs::path& folder) {
    std::error_code error;
    const auto existing = [&](const std::string& piece, bool any_kind) -> std::optional<fs::path> {
        for (const fs::path& path : {fs::path{piece}, folder / piece}) {
            if (any_kind ? fs::exists(path, error) : fs::is_regular_file(path, error)) return path;
        }
        return std::nullopt;
    };
    if (const auto whole = existing(name, true)) return whole;
    constexpr std::string_view between = "/,:;=?&\"'{}<>|";
    const auto is_between = [&](std::size_t at) { return between.find(name[at]) != std::string_view::npos; };
    for (std::size_t first = 0; first < name.size(); ++first) {
        if (first > 0 && name[first] != '/' && !is_between(first - 1)) continue;
        for (std::size_t end = name.size(); end > first; --end) {
            if (end < name.size() && !is_between(end)) continue;
            if (const auto found = existing(name.substr(first, end - first), false)) return found;
        }
    }
    return std::nullopt;
}

/// The names of the sources in the text of a virtual raster, those of its masks included.
void append_sources(const CPLXMLNode* node, std::vector<std::string>& names) {
    for (; node != nullptr; node = node->psNext) {
        const std::string_view element = node->eType == CXT_Element ? node->pszValue : "";
        if (element == "SourceFilename" || element == "SourceDataset")
            names.emplace_back(CPLGetXMLValue(node, nullptr, ""));
        append_sources(node->psChild, names);
    }
}

std::vector<std::string> sources_of(GDALDatasetH dataset) {
    std::vector<std::string> names;
    char** const text = GDALGetMetadata(dataset, "xml:VRT");
    if (CSLCount(text) == 0) return names;
    CPLXMLNode* const root = CPLParseXMLString(text[0]);
    append_sources(root, names);
    CPLDestroyXMLNode(root);
    return names;
}

/// Goes from a raster to its files and from a virtual one to its sources, to each once.
class Collector {
public:
    void visit(const std::string& name, const fs::path& folder, bool is_source) {
        if (name.empty() || !seen_.insert(folder.string() + '\n' + name).second) return;
        const auto file = file_in(name, folder);
        if (file) files_.push_back(*file);
        // A relative name of a virtual raster's source starts where that raster is.
        std::error_code error;
        const std::string opened = file && fs::exists(folder / name, error) ? (folder / name).string() : name;
        if (is_source && !is_virtual(opened)) return;
        const Dataset dataset = open_with_gdal(opened);
        if (!dataset) return;
        for (const std::string& each : files_of(dataset.get())) visit(each, "", true);
        const fs::path here = file ? file->parent_path() : folder;
        for (const std::string& each : sources_of(dataset.get())) visit(each, here, true);
    }
    [[nodiscard]] std::vector<fs::path> take() { return std::move(files_); }

private:
    /// Of a virtual raster alone GDAL lists no files of its sources.
    static bool is_virtual(const std::string& name) {
        const std::array<const char*, 2> only{"VRT", nullptr};
        return GDALIdentifyDriverEx(name.c_str(), GDAL_OF_RASTER, only.data(), nullptr) != nullptr;
    }

    std::set<std::string> seen_;
    std::vector<fs::path> files_;
};

} // namespace

std::vector<fs::path> files_with_gdal(const std::string& name) {
    Collector collector;
    collector.visit(name, "", false);
    return collector.take();
}

} // namespace demo
