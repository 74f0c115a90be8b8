# Finds the user's own OpenHaptics SDK (the HDAPI part): header HD/hd.h and library HD. Nothing of it is in this
# repository. Looked for under, in this order:
#   the variables OpenHaptics_ROOT and OPENHAPTICS_ROOT, CMake's or the environment's,
#   the environment's OH_SDK_BASE (SDK 3.1 and newer) and 3DTOUCH_BASE (older), as the SDK's installers set them,
#   the places where those installers put it on Linux and Windows, newest version first.
#
# Gives OpenHaptics_FOUND, OpenHaptics_INCLUDE_DIR, OpenHaptics_HD_LIBRARY and the target OpenHaptics::HD.

set(_oh_roots ${OPENHAPTICS_ROOT} $ENV{OPENHAPTICS_ROOT} $ENV{OH_SDK_BASE} $ENV{3DTOUCH_BASE})
foreach(_oh_place IN ITEMS /opt/OpenHaptics/Developer C:/OpenHaptics/Developer)
    file(GLOB _oh_versions LIST_DIRECTORIES TRUE ${_oh_place}/*)
    list(SORT _oh_versions COMPARE NATURAL ORDER DESCENDING)
    list(APPEND _oh_roots ${_oh_versions})
endforeach()
list(APPEND _oh_roots /opt/OpenHaptics /usr/share/3DTouch
    "C:/Program Files/SensAble/3DTouch" "C:/Program Files (x86)/SensAble/3DTouch")

if(CMAKE_SIZEOF_VOID_P EQUAL 4)
    set(_oh_suffixes lib lib/Win32/Release lib/win32/Release lib/Win32 lib/win32)
else()
    set(_oh_suffixes lib64 lib lib/x86_64-linux-gnu lib/x64/Release lib/x64 lib/win64)
endif()

find_path(OpenHaptics_INCLUDE_DIR NAMES HD/hd.h HINTS ${_oh_roots} PATH_SUFFIXES include usr/include)
find_library(OpenHaptics_HD_LIBRARY NAMES HD hd HINTS ${_oh_roots} PATH_SUFFIXES ${_oh_suffixes})
mark_as_advanced(OpenHaptics_INCLUDE_DIR OpenHaptics_HD_LIBRARY)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenHaptics REQUIRED_VARS OpenHaptics_HD_LIBRARY OpenHaptics_INCLUDE_DIR)

if(OpenHaptics_FOUND AND NOT TARGET OpenHaptics::HD)
    add_library(OpenHaptics::HD UNKNOWN IMPORTED)
    set_target_properties(OpenHaptics::HD PROPERTIES
        IMPORTED_LOCATION "${OpenHaptics_HD_LIBRARY}"
        INTERFACE_INCLUDE_DIRECTORIES "${OpenHaptics_INCLUDE_DIR}")
    if(CMAKE_SYSTEM_NAME STREQUAL "Linux")
        # The headers tell the system by `linux`, which compilers define only with their extensions (-std=gnu++20).
        set_target_properties(OpenHaptics::HD PROPERTIES INTERFACE_COMPILE_DEFINITIONS "linux=1")
    endif()
endif()
unset(_oh_roots)
unset(_oh_place)
unset(_oh_versions)
unset(_oh_suffixes)
