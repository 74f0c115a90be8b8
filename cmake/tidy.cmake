# Target tidy: no function is more complex than .clang-tidy lets it be, 25 for headers and 35 for tests, benchmarks and
# examples. Clang-tidy reads a build tree of its own, which is configured and not built: of Clang, whose options it
# understands, with what only Clang builds, and without precompiled headers of another compiler.
find_program(HFH_CLANG_TIDY NAMES clang-tidy-14 clang-tidy)
find_program(HFH_RUN_CLANG_TIDY NAMES run-clang-tidy-14 run-clang-tidy)
find_program(HFH_TIDY_COMPILER NAMES clang++)
mark_as_advanced(HFH_CLANG_TIDY HFH_RUN_CLANG_TIDY HFH_TIDY_COMPILER)
if(NOT HFH_CLANG_TIDY OR NOT HFH_RUN_CLANG_TIDY OR NOT HFH_TIDY_COMPILER)
    add_custom_target(tidy
        COMMAND ${CMAKE_COMMAND} -E echo "target tidy needs clang, clang-tidy and run-clang-tidy"
        COMMAND ${CMAKE_COMMAND} -E false)
    return()
endif()

# One source with every header, so that what they have in common is read once. A library, for the sake of its options.
list(TRANSFORM hfh_headers REPLACE "(.+)" "#include <hfh/\\1>\n" OUTPUT_VARIABLE hfh_tidy_headers)
string(JOIN "" hfh_tidy_headers ${hfh_tidy_headers})
file(CONFIGURE OUTPUT tidy_headers.cpp CONTENT "${hfh_tidy_headers}")
add_library(hfh_tidy_headers OBJECT EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/tidy_headers.cpp)
target_link_libraries(hfh_tidy_headers PRIVATE hfh::hfh)

set(hfh_tidy_tree ${PROJECT_BINARY_DIR}/tidy)
string(REGEX REPLACE "([][+.*()^$?|\\])" "\\\\\\1" hfh_tidy_sources ${PROJECT_SOURCE_DIR})
add_custom_target(tidy
    COMMAND ${CMAKE_COMMAND} -S ${PROJECT_SOURCE_DIR} -B ${hfh_tidy_tree} -G ${CMAKE_GENERATOR}
        -D CMAKE_CXX_COMPILER=${HFH_TIDY_COMPILER} -D CMAKE_PREFIX_PATH=${CMAKE_PREFIX_PATH}
        -D CMAKE_EXPORT_COMPILE_COMMANDS=ON -D CMAKE_DISABLE_PRECOMPILE_HEADERS=ON
    COMMAND ${HFH_CLANG_TIDY} --quiet -p ${hfh_tidy_tree}
        --config-file=${PROJECT_SOURCE_DIR}/include/hfh/.clang-tidy ${hfh_tidy_tree}/tidy_headers.cpp
    COMMAND ${HFH_RUN_CLANG_TIDY} -quiet -clang-tidy-binary ${HFH_CLANG_TIDY} -p ${hfh_tidy_tree}
        "^${hfh_tidy_sources}/(tests|bench|examples)/"
    USES_TERMINAL
    VERBATIM)
