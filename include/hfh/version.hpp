#ifndef HFH_VERSION_HPP
#define HFH_VERSION_HPP

// The only macros of the library that are meant for its users. CMakeLists.txt reads the version from here.

#define HFH_VERSION_MAJOR 0
#define HFH_VERSION_MINOR 2
#define HFH_VERSION_PATCH 0

#endif // HFH_VERSION_HPP
