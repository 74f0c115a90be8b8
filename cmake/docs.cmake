# Target docs: the pages and the reference as HTML, <build>/docs/html/index.html. Fails on a warning of Doxygen and on a
# link that leads nowhere.
find_program(HFH_DOXYGEN NAMES doxygen)
find_package(Python3 QUIET COMPONENTS Interpreter)
find_path(HFH_DOXYGEN_STYLE NAMES doxygen-awesome.css PATHS /usr/share/doxygen-awesome-css)
mark_as_advanced(HFH_DOXYGEN HFH_DOXYGEN_STYLE)
if(NOT HFH_DOXYGEN OR NOT Python3_Interpreter_FOUND)
    add_custom_target(docs
        COMMAND ${CMAKE_COMMAND} -E echo "target docs needs doxygen and python3, and looks better with doxygen-awesome-css"
        COMMAND ${CMAKE_COMMAND} -E false)
    return()
endif()

set(hfh_docs_dir ${PROJECT_BINARY_DIR}/docs)
set(hfh_docs_style "")
if(HFH_DOXYGEN_STYLE)
    set(hfh_docs_style "HTML_EXTRA_STYLESHEET  = \"${HFH_DOXYGEN_STYLE}/doxygen-awesome.css\" \
\"${PROJECT_SOURCE_DIR}/cmake/docs/style.css\"")
endif()
configure_file(cmake/docs/Doxyfile.in ${hfh_docs_dir}/Doxyfile @ONLY)
add_custom_target(docs
    COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/docs/pages.py ${PROJECT_SOURCE_DIR} ${hfh_docs_dir}/pages
        ${hfh_docs_dir}/html
    COMMAND ${HFH_DOXYGEN} ${hfh_docs_dir}/Doxyfile
    COMMAND ${Python3_EXECUTABLE} ${PROJECT_SOURCE_DIR}/cmake/docs/check_links.py ${hfh_docs_dir}/html
    USES_TERMINAL
    VERBATIM)
