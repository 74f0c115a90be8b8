# Every dependency is looked for on the system first and fetched only when it is not there. Each has a macro here, called
# where the dependency is used, so that a project which only wants the headers needs GLM and nothing else.

include(FetchContent)

# Fetched projects that ask for an old CMake shall still take the plain variables set below for their options.
set(CMAKE_POLICY_DEFAULT_CMP0077 NEW)

macro(hfh_use_glm)
    # A project that has its own GLM has its target already.
    if(NOT TARGET glm::glm)
        set(GLM_BUILD_LIBRARY OFF)
        # hfh's export set refers to glm::glm, so a GLM that was fetched has to be installed along with hfh.
        set(GLM_BUILD_INSTALL ${HFH_INSTALL})
        FetchContent_Declare(glm
            GIT_REPOSITORY https://github.com/g-truc/glm.git GIT_TAG 1.0.1 GIT_SHALLOW TRUE
            SYSTEM FIND_PACKAGE_ARGS)
        FetchContent_MakeAvailable(glm)
    endif()
endmacro()

macro(hfh_use_catch2)
    # No version: v2 and v3 both serve, see tests/catch.hpp.
    FetchContent_Declare(Catch2
        GIT_REPOSITORY https://github.com/catchorg/Catch2.git GIT_TAG v3.7.1 GIT_SHALLOW TRUE
        SYSTEM FIND_PACKAGE_ARGS)
    FetchContent_MakeAvailable(Catch2)
    if(NOT Catch2_FOUND)
        list(APPEND CMAKE_MODULE_PATH ${catch2_SOURCE_DIR}/extras)
    endif()
    include(Catch)
endmacro()

macro(hfh_use_benchmark)
    set(BENCHMARK_ENABLE_TESTING OFF)
    set(BENCHMARK_ENABLE_INSTALL OFF)
    FetchContent_Declare(benchmark
        GIT_REPOSITORY https://github.com/google/benchmark.git GIT_TAG v1.9.1 GIT_SHALLOW TRUE
        SYSTEM FIND_PACKAGE_ARGS)
    FetchContent_MakeAvailable(benchmark)
endmacro()

macro(hfh_use_png)
    set(PNG_SHARED OFF)
    set(PNG_TESTS OFF)
    set(PNG_TOOLS OFF)
    set(SKIP_INSTALL_ALL ON)
    FetchContent_Declare(PNG
        GIT_REPOSITORY https://github.com/pnggroup/libpng.git GIT_TAG v1.6.44 GIT_SHALLOW TRUE
        SYSTEM FIND_PACKAGE_ARGS)
    FetchContent_MakeAvailable(PNG)
    if(NOT TARGET PNG::PNG)
        # png.h includes a header that libpng's build generates.
        target_include_directories(png_static SYSTEM INTERFACE
            $<BUILD_INTERFACE:${png_SOURCE_DIR}> $<BUILD_INTERFACE:${png_BINARY_DIR}>)
        add_library(PNG::PNG ALIAS png_static)
    endif()
    unset(SKIP_INSTALL_ALL)
endmacro()

macro(hfh_use_cli11)
    FetchContent_Declare(CLI11
        GIT_REPOSITORY https://github.com/CLIUtils/CLI11.git GIT_TAG v2.4.2 GIT_SHALLOW TRUE
        SYSTEM FIND_PACKAGE_ARGS)
    FetchContent_MakeAvailable(CLI11)
endmacro()
