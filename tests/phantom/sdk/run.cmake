# Run by CTest: installs the fake SDK below WORK, finds it by the environment variable ROOT, builds phantom_touch against
# it and runs it for a second.
cmake_minimum_required(VERSION 3.25)

function(run)
    execute_process(COMMAND ${ARGV} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    message("${output}")
    if(NOT result EQUAL 0)
        list(JOIN ARGV " " command)
        message(FATAL_ERROR "exit status ${result}: ${command}")
    endif()
    set(output "${output}" PARENT_SCOPE)
endfunction()

foreach(variable IN ITEMS OH_SDK_BASE 3DTOUCH_BASE OPENHAPTICS_ROOT OpenHaptics_ROOT)
    unset(ENV{${variable}})
endforeach()
set(here ${CMAKE_CURRENT_LIST_DIR})
set(options -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${CXX} "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}" -DCMAKE_BUILD_TYPE=Release
    "-DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER}")
run(${CMAKE_COMMAND} -S ${here} -B ${WORK}/fake ${options} -DFAKE=ON -DCMAKE_INSTALL_PREFIX=${WORK}/sdk)
run(${CMAKE_COMMAND} --build ${WORK}/fake --config Release --target install)

set(ENV{${ROOT}} ${WORK}/sdk)
run(${CMAKE_COMMAND} --fresh -S ${here} -B ${WORK}/user ${options} -DHFH_SOURCE_DIR=${HFH_SOURCE_DIR})
run(${CMAKE_COMMAND} --build ${WORK}/user --config Release --target phantom_touch)
file(GLOB_RECURSE program ${WORK}/user/phantom/phantom_touch ${WORK}/user/phantom/phantom_touch.exe)
run(${program} 1)
if(NOT output MATCHES "stopped; ([0-9]+) updates" OR CMAKE_MATCH_1 LESS 100)
    message(FATAL_ERROR "phantom_touch has not run for a second")
endif()
