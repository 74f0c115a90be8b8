# Target amalgamated: all headers in one, <build>/amalgamated/hfh/hfh.hpp.
set(hfh_amalgamated_dir ${PROJECT_BINARY_DIR}/amalgamated)
list(TRANSFORM hfh_header_files PREPEND ${PROJECT_SOURCE_DIR}/ OUTPUT_VARIABLE hfh_amalgamated_from)
add_custom_command(OUTPUT ${hfh_amalgamated_dir}/hfh/hfh.hpp
    COMMAND ${CMAKE_COMMAND} -D SOURCE_DIR=${PROJECT_SOURCE_DIR} -D OUTPUT=${hfh_amalgamated_dir}/hfh/hfh.hpp
        -P ${PROJECT_SOURCE_DIR}/cmake/amalgamate.cmake
    DEPENDS ${hfh_amalgamated_from} cmake/headers.cmake cmake/amalgamate.cmake LICENSE
    COMMENT "All headers in one"
    VERBATIM)
add_custom_target(amalgamated DEPENDS ${hfh_amalgamated_dir}/hfh/hfh.hpp)
