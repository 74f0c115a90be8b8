# Writes all headers into one file: cmake -D SOURCE_DIR=... -D OUTPUT=... -P amalgamate.cmake
# The headers come in the order of cmake/headers.cmake, in which each stands behind those that it includes, so nothing is
# left to do but to leave out the lines by which they include each other. They keep their guards: a program may have both
# this file and single headers.
cmake_minimum_required(VERSION 3.25)
include(${SOURCE_DIR}/cmake/headers.cmake)

set(order version.hpp)
foreach(room IN LISTS hfh_rooms)
    foreach(name IN LISTS hfh_in_${room})
        list(APPEND order ${room}/${name}.hpp)
    endforeach()
endforeach()

file(READ ${SOURCE_DIR}/LICENSE licence)
string(REGEX REPLACE "\n+$" "" licence "${licence}")
string(REGEX REPLACE "\n" "\n// " licence "${licence}")
string(REGEX REPLACE " +\n" "\n" licence "${licence}")
set(text "// hfh, all headers in one, made by its target `amalgamated`: include it in place of <hfh/hfh.hpp> and of every\n")
string(APPEND text "// other header of the library. It needs C++20 and GLM.\n//\n// ${licence}\n")
foreach(header IN LISTS order)
    file(READ ${SOURCE_DIR}/include/hfh/${header} content)
    string(REGEX REPLACE "#include <hfh/[^>\n]*\\.hpp>\n" "" content "${content}")
    string(APPEND text "\n// ---- ${header}\n\n${content}")
endforeach()
string(REGEX REPLACE "\n\n\n+" "\n\n" text "${text}")
file(WRITE ${OUTPUT} "${text}")
