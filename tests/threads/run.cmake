# Run by CTest: cmake -D PROGRAM=... [-D RACE=ON] -P run.cmake
# Runs a program that was built with the thread sanitizer, and expects it to end well, or with RACE to be caught. On
# kernels that spread addresses wider than the sanitizer's run-time knows (vm.mmap_rnd_bits above 28 with older GCC), it
# gives up at once; there it is run again without the spreading.
cmake_minimum_required(VERSION 3.25)

set(ENV{TSAN_OPTIONS} "exitcode=66 halt_on_error=1")
set(command ${PROGRAM})
execute_process(COMMAND ${command} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE errors)
if(errors MATCHES "unexpected memory mapping")
    find_program(setarch setarch)
    if(setarch)
        message(STATUS "the sanitizer cannot place its memory; again with setarch -R")
        execute_process(COMMAND ${setarch} -R ${command} RESULT_VARIABLE result OUTPUT_VARIABLE output
            ERROR_VARIABLE errors)
    endif()
    if(NOT setarch OR errors MATCHES "unexpected memory mapping" OR errors MATCHES "failed to set personality")
        message("hfh: skipped: the thread sanitizer cannot place its memory on this kernel, and setarch -R is not allowed")
        return()
    endif()
endif()

message("${output}${errors}")
if(RACE)
    if(NOT result EQUAL 66 OR NOT errors MATCHES "WARNING: ThreadSanitizer: data race")
        message(FATAL_ERROR "the race was not found (exit status ${result})")
    endif()
elseif(NOT result EQUAL 0)
    message(FATAL_ERROR "exit status ${result}")
endif()
