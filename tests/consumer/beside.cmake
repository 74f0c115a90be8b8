# The library beside other people's code. Target check_beside builds it all.
add_custom_target(check_beside)

# One program, built as different projects would build it. Each build has to give the same answers, to the bit, and none a
# warning: all that GCC and Clang have against arithmetic and shadowed names is on.
set(hfh_strict -Wall -Wextra -Wpedantic -Wconversion -Wsign-conversion -Wshadow -Wold-style-cast -Wcast-qual
    -Wdouble-promotion -Werror $<$<CXX_COMPILER_ID:GNU>:-Wuseless-cast>)
function(hfh_add_answers name)
    cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEFINITIONS;OPTIONS;GLM")
    set(target hfh_answers_${name})
    add_executable(${target} consumer/answers.cpp)
    if(arg_GLM)
        target_include_directories(${target} SYSTEM PRIVATE ${arg_GLM})
        target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR}/include)
    else()
        target_link_libraries(${target} PRIVATE hfh::hfh)
    endif()
    target_compile_features(${target} PRIVATE cxx_std_20)
    target_compile_definitions(${target} PRIVATE ${arg_DEFINITIONS})
    target_compile_options(${target} PRIVATE ${hfh_strict} -O1 ${arg_OPTIONS})
    target_link_options(${target} PRIVATE ${arg_OPTIONS})
    add_dependencies(check_beside ${target})
    if(NOT name STREQUAL "plain")
        add_test(NAME consumer_answers_${name} COMMAND ${CMAKE_COMMAND}
            -D PROGRAM=$<TARGET_FILE:${target}> -D PLAIN=$<TARGET_FILE:hfh_answers_plain>
            -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/same_answers.cmake)
    endif()
endfunction()

hfh_add_answers(plain)
hfh_add_answers(glm_intrinsics DEFINITIONS GLM_FORCE_INTRINSICS)
# Aligned vectors as in GLM 0.9.9.8 and 1.0.1. Under 1.0.3 their dot product in float adds in another order.
hfh_add_answers(glm_aligned DEFINITIONS GLM_FORCE_INTRINSICS GLM_FORCE_DEFAULT_ALIGNED_GENTYPES
    OPTIONS $<$<CXX_COMPILER_ID:GNU>:-Wno-psabi>) # GCC notes that it passed such vectors in another way up to 4.5
hfh_add_answers(glm_options DEFINITIONS GLM_FORCE_CTOR_INIT GLM_FORCE_DEPTH_ZERO_TO_ONE GLM_FORCE_LEFT_HANDED
    GLM_FORCE_SWIZZLE GLM_FORCE_SIZE_T_LENGTH GLM_FORCE_EXPLICIT_CTOR GLM_FORCE_UNRESTRICTED_GENTYPE)
if(HFH_HAS_32_BITS)
    # There an Index is an int, so a cast from one to the other is useless.
    hfh_add_answers(32_bits OPTIONS ${hfh_narrow} $<$<CXX_COMPILER_ID:GNU>:-Wno-useless-cast>)
endif()
set(HFH_OTHER_GLM "" CACHE PATH "Folder with another version of GLM in glm/, to test the library beside that one as well")
if(HFH_OTHER_GLM)
    hfh_add_answers(other_glm GLM ${HFH_OTHER_GLM})
endif()

# Every header under the macros min and max of <windows.h>. The standard library of GCC does not stand them, so what the
# headers take from it comes before.
set(hfh_under_macros "")
foreach(name IN ITEMS algorithm array atomic bit cmath concepts cstddef cstdint iterator limits memory numeric optional
    type_traits utility)
    string(APPEND hfh_under_macros "#include <${name}>\n")
endforeach()
string(APPEND hfh_under_macros
    "#define min(a, b) (((a) < (b)) ? (a) : (b))\n#define max(a, b) (((a) > (b)) ? (a) : (b))\n")
list(TRANSFORM hfh_headers REPLACE "(.+)" "#include <hfh/\\1>\n" OUTPUT_VARIABLE all_headers)
string(JOIN "" all_headers ${all_headers})
string(APPEND hfh_under_macros "${all_headers}")
file(CONFIGURE OUTPUT beside/under_macros.cpp CONTENT "${hfh_under_macros}" @ONLY)
add_library(hfh_under_macros OBJECT ${CMAKE_CURRENT_BINARY_DIR}/beside/under_macros.cpp)
target_link_libraries(hfh_under_macros PRIVATE hfh::hfh)
target_compile_options(hfh_under_macros PRIVATE ${hfh_strict} -O0)
add_dependencies(check_beside hfh_under_macros)

# All headers in one, and the consumer's program with that and nothing else.
# By a source of the build tree's, for clang-tidy reads sources of the project before the header is made.
file(CONFIGURE OUTPUT beside/amalgamated.cpp CONTENT "#include \"${CMAKE_CURRENT_SOURCE_DIR}/consumer/main.cpp\"\n" @ONLY)
add_executable(hfh_consumer_amalgamated ${CMAKE_CURRENT_BINARY_DIR}/beside/amalgamated.cpp)
add_dependencies(hfh_consumer_amalgamated amalgamated)
target_include_directories(hfh_consumer_amalgamated PRIVATE ${hfh_amalgamated_dir})
target_link_libraries(hfh_consumer_amalgamated PRIVATE glm::glm)
target_compile_features(hfh_consumer_amalgamated PRIVATE cxx_std_20)
target_compile_options(hfh_consumer_amalgamated PRIVATE ${hfh_strict} -fno-exceptions -fno-rtti)
add_test(NAME consumer_amalgamated COMMAND hfh_consumer_amalgamated)
add_dependencies(check_beside hfh_consumer_amalgamated)

# A compiler that is told C++17 says what is wrong, once.
add_test(NAME consumer_needs_cpp20 COMMAND ${CMAKE_COMMAND} -D CXX=${CMAKE_CXX_COMPILER} -D INCLUDE=${PROJECT_SOURCE_DIR}/include
    -D SOURCE=${CMAKE_CURRENT_SOURCE_DIR}/consumer/main.cpp -P ${CMAKE_CURRENT_SOURCE_DIR}/consumer/needs_cpp20.cmake)

# For Windows, where MinGW is installed: every header and the program that gives the answers compile.
find_program(HFH_MINGW NAMES x86_64-w64-mingw32-g++-posix x86_64-w64-mingw32-g++)
mark_as_advanced(HFH_MINGW)
if(HFH_MINGW)
    file(CONFIGURE OUTPUT beside/windows.cpp CONTENT "#include <windows.h>\n${all_headers}")
    set(sources ${CMAKE_CURRENT_BINARY_DIR}/beside/windows.cpp ${CMAKE_CURRENT_SOURCE_DIR}/consumer/answers.cpp)
    add_test(NAME consumer_mingw COMMAND ${HFH_MINGW} -std=c++20 -fsyntax-only -Wall -Wextra -Wpedantic -Wconversion -Wshadow
        -Wdouble-promotion -Werror -isystem ${CMAKE_CURRENT_BINARY_DIR}/own_glm -I ${PROJECT_SOURCE_DIR}/include ${sources})
else()
    hfh_add_skipped_test(consumer_mingw "MinGW (package g++-mingw-w64-x86-64) is not installed")
endif()
