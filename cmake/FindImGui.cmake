# Debian's Dear ImGui is a static library without a CMake configuration, its backends for GLFW and OpenGL inside. Defines
# ImGui::ImGui; link glfw after it.
find_path(IMGUI_INCLUDE_DIR imgui.h PATH_SUFFIXES imgui)
find_path(IMGUI_BACKENDS_INCLUDE_DIR imgui_impl_glfw.h PATH_SUFFIXES imgui/backends)
find_library(IMGUI_LIBRARY imgui)
find_library(STB_LIBRARY stb)  # reads its fonts

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(ImGui REQUIRED_VARS IMGUI_LIBRARY STB_LIBRARY IMGUI_INCLUDE_DIR
                                                      IMGUI_BACKENDS_INCLUDE_DIR)
mark_as_advanced(IMGUI_INCLUDE_DIR IMGUI_BACKENDS_INCLUDE_DIR IMGUI_LIBRARY STB_LIBRARY)

if(ImGui_FOUND AND NOT TARGET ImGui::ImGui)
  add_library(ImGui::ImGui INTERFACE IMPORTED)
  target_include_directories(ImGui::ImGui INTERFACE ${IMGUI_INCLUDE_DIR} ${IMGUI_BACKENDS_INCLUDE_DIR})
  target_link_libraries(ImGui::ImGui INTERFACE ${IMGUI_LIBRARY} ${STB_LIBRARY} ${CMAKE_DL_LIBS})
endif()
