# SuiteSparse 5 ships no CMake configuration. Defines CHOLMOD::CHOLMOD: CHOLMOD and the OpenBLAS beneath it.
#
# Order matters: libcholmod brings a second BLAS of its own. Linked first, this one serves both the program and
# CHOLMOD, so that bounding its threads bounds all there are.
find_path(CHOLMOD_INCLUDE_DIR suitesparse/cholmod.h)
find_path(CBLAS_INCLUDE_DIR cblas.h PATH_SUFFIXES openblas-pthread openblas)
find_library(OPENBLAS_LIBRARY openblas)
find_library(CHOLMOD_LIBRARY cholmod)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CHOLMOD REQUIRED_VARS CHOLMOD_LIBRARY CHOLMOD_INCLUDE_DIR OPENBLAS_LIBRARY
                                                        CBLAS_INCLUDE_DIR)
mark_as_advanced(CHOLMOD_INCLUDE_DIR CBLAS_INCLUDE_DIR OPENBLAS_LIBRARY CHOLMOD_LIBRARY)

if(CHOLMOD_FOUND AND NOT TARGET CHOLMOD::CHOLMOD)
  add_library(CHOLMOD::CHOLMOD INTERFACE IMPORTED)
  target_include_directories(CHOLMOD::CHOLMOD INTERFACE ${CHOLMOD_INCLUDE_DIR} ${CBLAS_INCLUDE_DIR})
  target_link_libraries(CHOLMOD::CHOLMOD INTERFACE ${OPENBLAS_LIBRARY} ${CHOLMOD_LIBRARY})
endif()
