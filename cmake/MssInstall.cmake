# What `cmake --install` puts below a prefix for other programs, and the Debian packages that `cpack -G DEB` makes of it:
# libmss-dev (component development: headers, static libraries, CMake and pkg-config files), mss (program: the program
# with its scenes and baselines) and python3-mss (python).
include(CMakePackageConfigHelpers)

set(config_folder ${CMAKE_INSTALL_LIBDIR}/cmake/mss)
set(header_folder ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS mss_core mss_integrators EXPORT mssTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
        FILE_SET HEADERS DESTINATION ${header_folder} COMPONENT development)
install(EXPORT mssTargets NAMESPACE mss:: DESTINATION ${config_folder} COMPONENT development)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/mssConfig.cmake.in ${PROJECT_BINARY_DIR}/mssConfig.cmake
                              INSTALL_DESTINATION ${config_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/mssConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/mssConfig.cmake ${PROJECT_BINARY_DIR}/mssConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/FindCHOLMOD.cmake
        DESTINATION ${config_folder} COMPONENT development)

file(RELATIVE_PATH prefix_from_pkgconfig /prefix/${CMAKE_INSTALL_LIBDIR}/pkgconfig /prefix)
set(epoxy_of_pkgconfig "")
if(MSS_HAS_DEVICES)
  set(epoxy_of_pkgconfig " epoxy")
endif()
configure_file(${PROJECT_SOURCE_DIR}/cmake/mss.pc.in ${PROJECT_BINARY_DIR}/mss.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/mss.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

set(CPACK_GENERATOR DEB)
set(MSS_PACKAGE_CONTACT "the mss authors <unset@example.invalid>" CACHE STRING "Maintainer of the Debian packages")
set(CPACK_PACKAGE_CONTACT "${MSS_PACKAGE_CONTACT}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL development)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)  # what programs and modules link; needs dpkg-dev and file

# Static libraries link what they need into the program that uses them.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libmss-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "libraries, headers, CMake and pkg-config files")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "g++, libeigen3-dev, libfmt-dev, libtomlplusplus-dev, libsuitesparse-dev, libopenblas-dev, libsundials-dev")
if(MSS_HAS_DEVICES)
  string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", pkgconf, libepoxy-dev")
endif()
set(notices libmss-dev)

if(MSS_PROGRAM)
  list(APPEND CPACK_COMPONENTS_ALL program)
  list(APPEND notices mss)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME mss)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "gnuplot-nox, fonts-dejavu-core")  # charts
  set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "the program, its scenes and baselines")
endif()

if(MSS_PROGRAM AND MSS_HAS_PYTHON)
  list(APPEND CPACK_COMPONENTS_ALL python)
  list(APPEND notices python3-mss)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-mss)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  # The module is compiled for one version of Python; scenes are those of the program.
  math(EXPR next_python "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
      "python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy, mss (= ${PROJECT_VERSION})")
  set(CPACK_COMPONENT_PYTHON_DESCRIPTION "the Python module")
endif()

foreach(package component IN ZIP_LISTS notices CPACK_COMPONENTS_ALL)
  install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} RENAME copyright
          COMPONENT ${component})
endforeach()
include(CPack)
