# Run by CTest: installs the fake SDK below WORK, finds it by the environment, builds phantom_touch against it and runs it
# for a second; then again with signals while there is force, and with a connection that breaks (see hand.cpp). Before
# that, without an SDK, sees that nothing is built and that this is said.
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

run(${CMAKE_COMMAND} --fresh -S ${here} -B ${WORK}/none ${options} -DHFH_SOURCE_DIR=${HFH_SOURCE_DIR}
    -DCMAKE_DISABLE_FIND_PACKAGE_OpenHaptics=ON)
if(NOT output MATCHES "phantom_touch: no OpenHaptics SDK.*not built" OR NOT output MATCHES "phantom_touch is not a target")
    message(FATAL_ERROR "phantom_touch is built without an SDK, or nothing is said")
endif()

set(ENV{OH_SDK_BASE} ${WORK}/sdk)
run(${CMAKE_COMMAND} --fresh -S ${here} -B ${WORK}/user ${options} -DHFH_SOURCE_DIR=${HFH_SOURCE_DIR})
if(NOT output MATCHES "phantom_touch is a target")
    message(FATAL_ERROR "phantom_touch is not built though the SDK is there")
endif()
run(${CMAKE_COMMAND} --build ${WORK}/user --config Release --target phantom_touch)
file(GLOB_RECURSE program ${WORK}/user/phantom/phantom_touch ${WORK}/user/phantom/phantom_touch.exe)
run(${program} 1)
if(NOT output MATCHES "stopped; ([0-9]+) updates" OR CMAKE_MATCH_1 LESS 100)
    message(FATAL_ERROR "phantom_touch has not run for a second")
endif()
if(output MATCHES "breach: ")
    message(FATAL_ERROR "a call out of order")
endif()

foreach(event IN ITEMS INT TERM)
    set(ENV{HFH_TEST_EVENT} ${event})
    run(${program} 20)
    if(NOT output MATCHES "signal at ([0-9.]+) N" OR CMAKE_MATCH_1 LESS 0.5)
        message(FATAL_ERROR "no force when SIG${event} came, so this test says nothing")
    endif()
    if(NOT output MATCHES "stopped; ([0-9]+) updates" OR CMAKE_MATCH_1 GREATER 602
       OR NOT output MATCHES "left at 0.00 N" OR output MATCHES "breach: ")
        message(FATAL_ERROR "SIG${event} does not end the run in order within two updates")
    endif()
endforeach()

set(ENV{HFH_TEST_EVENT} LOSE)
run(${program} 4)
if(NOT output MATCHES "the connection broke; 602 updates.*it did not start; 0 updates.*stopped; ([0-9]+) updates" OR CMAKE_MATCH_1 LESS 100)
    message(FATAL_ERROR "a connection that broke is not opened anew until the device starts again")
endif()
