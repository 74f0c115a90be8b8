# Run by CTest: cmake -D MODULES=... -D WORK=... -P find.cmake
# Lays out made-up SDKs of empty files as the installers lay out theirs, for Linux and for Windows, and looks which one
# FindOpenHaptics finds.
cmake_minimum_required(VERSION 3.25)

set(here ${CMAKE_CURRENT_LIST_DIR})
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
set(names OH_SDK_BASE 3DTOUCH_BASE OPENHAPTICS_ROOT OpenHaptics_ROOT)
set(failures 0)
set(cases 0)

# An SDK under the case's root: its include directory's and its library's place.
function(sdk directory include library)
    file(WRITE ${WORK}/${directory}/${include}/HD/hd.h "")
    file(WRITE ${WORK}/${directory}/${library} "")
endfunction()

# expect(what SYSTEM DIRECTORY ROOT [SDK INCLUDE LIBRARY] [BITS 4] [ENV name=value...] [DEFINE name=value...])
# Looks from SYSTEM, whose whole file system is DIRECTORY; no SDK: expects that nothing is found.
function(expect what)
    cmake_parse_arguments(PARSE_ARGV 1 case "" "SYSTEM;ROOT;INCLUDE;LIBRARY;BITS" "ENV;DEFINE")
    foreach(name IN LISTS names)
        unset(ENV{${name}})
    endforeach()
    foreach(pair IN LISTS case_ENV)
        string(REGEX MATCH "^([^=]+)=(.*)$" pair "${pair}")
        set(ENV{${CMAKE_MATCH_1}} "${CMAKE_MATCH_2}")
    endforeach()
    if(NOT case_BITS)
        set(case_BITS 8)
    endif()
    execute_process(
        COMMAND ${CMAKE_COMMAND} --fresh -S ${here}/find -B ${WORK}/build -DCMAKE_MODULE_PATH=${MODULES}
            -DCMAKE_SYSTEM_NAME=${case_SYSTEM} -DBITS=${case_BITS} -DCMAKE_FIND_ROOT_PATH=${WORK}/${case_ROOT}
            -DCMAKE_FIND_ROOT_PATH_MODE_INCLUDE=ONLY -DCMAKE_FIND_ROOT_PATH_MODE_LIBRARY=ONLY ${case_DEFINE}
        RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(case_LIBRARY)
        set(definition linux=1)
        if(case_SYSTEM STREQUAL "Windows")
            set(definition WIN32)
        endif()
        set(expected "found <${WORK}/${case_LIBRARY}> <${WORK}/${case_INCLUDE}> <${definition}>")
    else()
        set(expected "found nothing")
    endif()
    string(FIND "${output}" "${expected}" place)
    if(place EQUAL -1 OR NOT result EQUAL 0)
        message("FAILED: ${what}\n  expected: ${expected}\n${output}")
        math(EXPR failures "${failures} + 1")
    endif()
    math(EXPR cases "${cases} + 1")
    set(failures ${failures} PARENT_SCOPE)
    set(cases ${cases} PARENT_SCOPE)
endfunction()

# ---- Linux
file(MAKE_DIRECTORY ${WORK}/empty)
expect("nothing where there is nothing" SYSTEM Linux ROOT empty)

set(home linux/opt/OpenHaptics/Developer)
sdk(${home}/3.4-0 include lib/libHD.so)
sdk(${home}/3.10-0 include lib/libHD.so)
expect("the newest of the usual place, by number" SYSTEM Linux ROOT linux
    INCLUDE ${home}/3.10-0/include LIBRARY ${home}/3.10-0/lib/libHD.so)
sdk(academic/opt/OpenHaptics/Academic/3.1 include lib64/libHD.so)
expect("the academic edition" SYSTEM Linux ROOT academic
    INCLUDE academic/opt/OpenHaptics/Academic/3.1/include LIBRARY academic/opt/OpenHaptics/Academic/3.1/lib64/libHD.so)
sdk(old/usr/share/3DTouch include lib/libHD.so)
expect("the old place" SYSTEM Linux ROOT old
    INCLUDE old/usr/share/3DTouch/include LIBRARY old/usr/share/3DTouch/lib/libHD.so)
sdk(system/usr include lib/libHD.so)
expect("the system's own directories" SYSTEM Linux ROOT system
    INCLUDE system/usr/include LIBRARY system/usr/lib/libHD.so)

sdk(linux/home/unpacked usr/include usr/lib/libHD.so)
sdk(linux/home/other include lib/libHD.so)
foreach(name IN LISTS names)
    expect("${name} before the usual place" SYSTEM Linux ROOT linux ENV "${name}=${WORK}/linux/home/unpacked"
        INCLUDE linux/home/unpacked/usr/include LIBRARY linux/home/unpacked/usr/lib/libHD.so)
endforeach()
foreach(name IN ITEMS OPENHAPTICS_ROOT OpenHaptics_ROOT)
    expect("the variable ${name} before the environment" SYSTEM Linux ROOT linux
        DEFINE "-D${name}=${WORK}/linux/home/other" ENV "OH_SDK_BASE=${WORK}/linux/home/unpacked"
        INCLUDE linux/home/other/include LIBRARY linux/home/other/lib/libHD.so)
endforeach()
expect("OH_SDK_BASE before 3DTOUCH_BASE" SYSTEM Linux ROOT linux
    ENV "3DTOUCH_BASE=${WORK}/linux/home/unpacked" "OH_SDK_BASE=${WORK}/linux/home/other"
    INCLUDE linux/home/other/include LIBRARY linux/home/other/lib/libHD.so)
expect("the usual place when a variable points nowhere" SYSTEM Linux ROOT linux ENV "OH_SDK_BASE=${WORK}/linux/gone"
    INCLUDE ${home}/3.10-0/include LIBRARY ${home}/3.10-0/lib/libHD.so)

file(WRITE ${WORK}/header/opt/OpenHaptics/Developer/3.4-0/include/HD/hd.h "")
expect("a header alone is nothing" SYSTEM Linux ROOT header)
file(WRITE ${WORK}/library/opt/OpenHaptics/Developer/3.4-0/lib/libHD.so "")
expect("a library alone is nothing" SYSTEM Linux ROOT library)

# ---- Windows
expect("nothing on Windows either" SYSTEM Windows ROOT empty)
set(home windows/OpenHaptics/Developer)
sdk(${home}/3.5.0 include lib/x64/Release/hd.lib)
sdk(${home}/3.5.0 include lib/Win32/Release/hd.lib)
sdk(${home}/3.4.0 include lib/x64/Release/hd.lib)
expect("64 bits of the newest" SYSTEM Windows ROOT windows
    INCLUDE ${home}/3.5.0/include LIBRARY ${home}/3.5.0/lib/x64/Release/hd.lib)
expect("32 bits of the newest" SYSTEM Windows ROOT windows BITS 4
    INCLUDE ${home}/3.5.0/include LIBRARY ${home}/3.5.0/lib/Win32/Release/hd.lib)
sdk(edition/OpenHaptics/Academic/3.1 include lib/x64/ReleaseAcademicEdition/hd.lib)
expect("the academic edition on Windows" SYSTEM Windows ROOT edition
    INCLUDE edition/OpenHaptics/Academic/3.1/include
    LIBRARY edition/OpenHaptics/Academic/3.1/lib/x64/ReleaseAcademicEdition/hd.lib)
foreach(program_files IN ITEMS "Program Files" "Program Files (x86)")
    set(place "${program_files}/drive/${program_files}/SensAble/3DTouch")
    sdk("${place}" include lib/x64/HD.lib)
    expect("the old place on Windows, ${program_files}" SYSTEM Windows ROOT "${program_files}/drive"
        INCLUDE "${place}/include" LIBRARY "${place}/lib/x64/HD.lib")
endforeach()
sdk(windows/elsewhere include lib/x64/Release/hd.lib)
foreach(name IN ITEMS OH_SDK_BASE 3DTOUCH_BASE OPENHAPTICS_ROOT)
    string(REPLACE "/" "\\" value "${WORK}/windows/elsewhere/")
    expect("${name} with backslashes, also at the end" SYSTEM Windows ROOT windows ENV "${name}=${value}"
        INCLUDE windows/elsewhere/include LIBRARY windows/elsewhere/lib/x64/Release/hd.lib)
endforeach()

if(failures)
    message(FATAL_ERROR "${failures} of ${cases} failed")
endif()
message("${cases} times the right one")
