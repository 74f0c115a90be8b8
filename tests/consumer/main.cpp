#include <hfh/hfh.hpp>

#include <cstdio>

int main() {
    std::printf("hfh %d.%d.%d\n", HFH_VERSION_MAJOR, HFH_VERSION_MINOR, HFH_VERSION_PATCH);
}
