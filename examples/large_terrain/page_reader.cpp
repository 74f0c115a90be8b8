#include "page_reader.hpp"

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#ifndef MADV_POPULATE_READ // Linux 5.14
#define MADV_POPULATE_READ 22
#endif

namespace large_terrain {

PageReader::PageReader() : page_{static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE))} {}

void PageReader::bring_in(const SampleLayout& layout, const hfh::VertexRange& box, hfh::Index first,
                          bool upwards) {
    const auto each = [&](auto&& visit) { for_each_page_range(layout, box, first, upwards, page_, visit); };
    const auto advise = [](const PageRange& range, int advice) {
        return ::madvise(reinterpret_cast<void*>(range.begin), range.end - range.begin, advice) == 0;
    };
    // First all reads are asked for, so that the disk has them at the same time; then each is waited for and its pages
    // are mapped, what is nearest and ahead first.
    each([&](const PageRange& range) {
        (void)advise(range, MADV_WILLNEED);
        ++ranges_;
    });
    each([&](const PageRange& range) {
        can_populate_ = can_populate_ && advise(range, MADV_POPULATE_READ);
        if (can_populate_) return;
        for (std::uintptr_t at = range.begin; at < range.end; at += page_) {
            (void)*reinterpret_cast<const volatile char*>(at);
        }
    });
}

void run_at_low_priority() noexcept {
    // Linux takes a thread for a process here.
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), 10);
}

long page_reads_of_this_thread() noexcept {
    rusage usage{};
    return ::getrusage(RUSAGE_THREAD, &usage) == 0 ? usage.ru_majflt : 0;
}

} // namespace large_terrain
