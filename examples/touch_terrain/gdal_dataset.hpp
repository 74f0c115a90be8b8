#ifndef TOUCH_TERRAIN_GDAL_DATASET_HPP
#define TOUCH_TERRAIN_GDAL_DATASET_HPP

#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>

#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace demo {

struct DatasetCloser {
    void operator()(GDALDatasetH dataset) const noexcept { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<std::remove_pointer_t<GDALDatasetH>, DatasetCloser>;

/// The raster that GDAL knows by `name`; null if there is none.
[[nodiscard]] inline Dataset open_with_gdal(const std::string& name) {
    GDALAllRegister();
    CPLSetErrorHandler(CPLQuietErrorHandler);
    CPLErrorReset();
    return Dataset{GDALOpenEx(name.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, nullptr, nullptr, nullptr)};
}

/// The files that GDAL reads for `dataset`, as it names them.
[[nodiscard]] inline std::vector<std::string> files_of(GDALDatasetH dataset) {
    std::vector<std::string> files;
    char** const list = GDALGetFileList(dataset);
    for (int k = 0; k < CSLCount(list); ++k) files.emplace_back(list[k]);
    CSLDestroy(list);
    return files;
}

} // namespace demo

#endif // TOUCH_TERRAIN_GDAL_DATASET_HPP
