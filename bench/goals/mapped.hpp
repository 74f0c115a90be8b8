#ifndef HFH_BENCH_GOALS_MAPPED_HPP
#define HFH_BENCH_GOALS_MAPPED_HPP

#include "goal.hpp"
#include "ground.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace hfh::bench {

/// Bytes that the system can give without paging; 0 if it does not say.
[[nodiscard]] inline double available_memory() {
    std::ifstream info{"/proc/meminfo"};
    for (std::string key, rest; info >> key && std::getline(info, rest);) {
        if (key == "MemAvailable:") return 1024 * std::stod(rest);
    }
    return 0;
}

/// The hills as a file of `side` × `side` samples, mapped into memory with all pages resident. The file is made if it is
/// not there, or not of these hills.
[[nodiscard]] inline Ground<std::int16_t> mapped_hills(const std::string& directory, Index side) {
    const std::string path = directory + "/hills_" + std::to_string(side) + ".i16";
    const auto row_bytes = 2 * static_cast<std::size_t>(side),
               bytes = row_bytes * static_cast<std::size_t>(side);
    const Hills hills;
    std::vector<std::int16_t> row(static_cast<std::size_t>(side));

    const auto is_whole = [&] {
        struct stat info {};
        if (stat(path.c_str(), &info) != 0 || static_cast<std::size_t>(info.st_size) != bytes) return false;
        std::ifstream file{path, std::ios::binary};
        std::vector<std::int16_t> stored(row.size());
        for (const Index j : {Index{0}, side / 3, side - 1}) {
            hills.row(j, side, row.data());
            file.seekg(static_cast<std::streamoff>(row_bytes) * j);
            file.read(reinterpret_cast<char*>(stored.data()), static_cast<std::streamsize>(row_bytes));
            if (!file || stored != row) return false;
        }
        return true;
    };
    if (!is_whole()) {
        std::ofstream file{path, std::ios::binary};
        for (Index j = 0; j < side; ++j) {
            hills.row(j, side, row.data());
            file.write(reinterpret_cast<const char*>(row.data()), static_cast<std::streamsize>(row_bytes));
        }
        if (!file.flush()) throw std::runtime_error{"cannot write " + path};
    }

    const int file = open(path.c_str(), O_RDONLY);
    if (file < 0) throw std::runtime_error{"cannot open " + path};
    void* const memory = mmap(nullptr, bytes, PROT_READ, MAP_SHARED | MAP_POPULATE, file, 0);
    close(file);
    if (memory == MAP_FAILED) throw std::runtime_error{"cannot map " + path};
    const auto* samples = static_cast<const std::int16_t*>(memory);
    Ground<std::int16_t> ground{{"hills, mapped",
                                 "",
                                 Source::generated,
                                 side,
                                 side,
                                 {Hills::spacing, Hills::spacing},
                                 Hills::lowest,
                                 Hills::highest},
                                {samples, [memory, bytes](const std::int16_t*) { munmap(memory, bytes); }}};
    ground.steepest = Hills::steepest;
    return ground;
}

} // namespace hfh::bench

#endif // HFH_BENCH_GOALS_MAPPED_HPP
