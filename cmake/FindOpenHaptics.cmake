# Finds the user's own OpenHaptics SDK (the HDAPI part): header HD/hd.h and library HD. Nothing of it is in this
# repository. Looked for under, in this order:
#   the variables OpenHaptics_ROOT and OPENHAPTICS_ROOT, CMake's or the environment's,
#   the environment's OH_SDK_BASE (SDK 3.1 and newer) and 3DTOUCH_BASE (older), as the SDK's installers set them,
#   the places where those installers put it on Linux and Windows, newest version first,
#   the system's own directories, where the installer for Linux puts links.
#
# Gives OpenHaptics_FOUND, OpenHaptics_INCLUDE_DIR, OpenHaptics_HD_LIBRARY and the target OpenHaptics::HD.

set(_oh_roots "")
foreach(_oh_root IN ITEMS "${OPENHAPTICS_ROOT}" "$ENV{OPENHAPTICS_ROOT}" "$ENV{OH_SDK_BASE}" "$ENV{3DTOUCH_BASE}")
    # An installer for Windows ends them in a backslash, which would escape the list's next semicolon.
    string(REPLACE "\\" "/" _oh_root "${_oh_root}")
    if(_oh_root)
        list(APPEND _oh_roots "${_oh_root}")
    endif()
endforeach()

if(WIN32)
    set(_oh_tops C:)
    set(_oh_places OpenHaptics/Developer OpenHaptics/Academic)
    set(_oh_fixed "Program Files/SensAble/3DTouch" "Program Files (x86)/SensAble/3DTouch")
else()
    set(_oh_tops "")
    set(_oh_places opt/OpenHaptics/Developer opt/OpenHaptics/Academic)
    set(_oh_fixed opt/OpenHaptics usr/share/3DTouch)
endif()
# Across systems, the other one's places; find_path does the same with what it is given, but a pattern it is not given.
foreach(_oh_top IN LISTS CMAKE_FIND_ROOT_PATH ITEMS "${_oh_tops}")
    foreach(_oh_place IN LISTS _oh_places)
        file(GLOB _oh_versions LIST_DIRECTORIES TRUE "${_oh_top}/${_oh_place}/*")
        list(SORT _oh_versions COMPARE NATURAL ORDER DESCENDING)
        list(APPEND _oh_roots ${_oh_versions})
    endforeach()
    foreach(_oh_place IN LISTS _oh_fixed)
        list(APPEND _oh_roots "${_oh_top}/${_oh_place}")
    endforeach()
endforeach()

if(CMAKE_SIZEOF_VOID_P EQUAL 4)
    set(_oh_machines Win32 win32)
else()
    set(_oh_machines x64 win64)
endif()
set(_oh_suffixes "")
foreach(_oh_place IN LISTS _oh_machines)
    list(APPEND _oh_suffixes lib/${_oh_place}/Release lib/${_oh_place}/ReleaseAcademicEdition lib/${_oh_place})
endforeach()
if(NOT CMAKE_SIZEOF_VOID_P EQUAL 4)
    list(APPEND _oh_suffixes lib64 usr/lib64 lib/x86_64-linux-gnu)
endif()
list(APPEND _oh_suffixes lib usr/lib)

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
    # The headers tell the system by names that compilers define only with their extensions (linux, under -std=gnu++20)
    # or not at all (WIN32).
    if(WIN32)
        set_target_properties(OpenHaptics::HD PROPERTIES INTERFACE_COMPILE_DEFINITIONS WIN32)
    elseif(CMAKE_SYSTEM_NAME STREQUAL "Linux")
        set_target_properties(OpenHaptics::HD PROPERTIES INTERFACE_COMPILE_DEFINITIONS linux=1)
    endif()
endif()
foreach(_oh_place IN ITEMS root roots tops top places place fixed versions machines suffixes)
    unset(_oh_${_oh_place})
endforeach()
unset(_oh_place)
