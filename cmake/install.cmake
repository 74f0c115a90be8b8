include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Only headers are installed, so nothing depends on the architecture.
set(hfh_config_dir ${CMAKE_INSTALL_DATADIR}/cmake/hfh)

# File sets mean nothing to a consumer older than CMake 3.23; this line serves those.
target_include_directories(hfh INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)

install(TARGETS hfh EXPORT hfh-targets FILE_SET HEADERS)
install(EXPORT hfh-targets NAMESPACE hfh:: DESTINATION ${hfh_config_dir})

configure_package_config_file(cmake/hfh-config.cmake.in ${PROJECT_BINARY_DIR}/hfh-config.cmake
    INSTALL_DESTINATION ${hfh_config_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/hfh-config-version.cmake
    COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${PROJECT_BINARY_DIR}/hfh-config.cmake ${PROJECT_BINARY_DIR}/hfh-config-version.cmake
    DESTINATION ${hfh_config_dir})

# A GLM that was fetched is installed next to hfh and has no .pc file of its own.
if(glm_FOUND)
    set(hfh_pc_requires glm)
endif()
configure_file(cmake/hfh.pc.in ${PROJECT_BINARY_DIR}/hfh.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/hfh.pc DESTINATION ${CMAKE_INSTALL_DATADIR}/pkgconfig)

install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
