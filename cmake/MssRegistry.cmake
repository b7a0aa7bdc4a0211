# mss_registry(LIST TYPE HEADER name...) writes the source of `const std::vector<TYPE>& LIST()`, which HEADER declares:
# what the functions `TYPE name()` return, in this order, which lists and charts follow. LIST, TYPE and names are in mss,
# or say where in it, as in studies::timing::experiment. The source's path is left in registry.
function(mss_registry list type header)
  set(declarations "")
  foreach(name IN LISTS ARGN)
    mss_in_namespace(declaration ${name} "mss::${type}" "();")
    string(APPEND declarations "${declaration}\n")
  endforeach()
  list(TRANSFORM ARGN PREPEND "mss::")
  list(TRANSFORM ARGN APPEND "()")
  list(JOIN ARGN ", " calls)
  mss_in_namespace(definition ${list} "const std::vector<mss::${type}>&" "() {
  static const std::vector<mss::${type}> all{${calls}};
  return all;
}")
  string(REPLACE "::" "_" file ${list})
  set(path ${CMAKE_CURRENT_BINARY_DIR}/${file}_registry.cpp)
  file(CONFIGURE OUTPUT ${path} @ONLY CONTENT "// Generated from the list in ${CMAKE_CURRENT_SOURCE_DIR}/CMakeLists.txt.
#include \"${header}\"

${declarations}
${definition}
")
  set(registry ${path} PARENT_SCOPE)
endfunction()

# Leaves in RESULT what puts `TYPE name REST` into the namespace that the name says, below mss.
function(mss_in_namespace result name type rest)
  set(space mss)
  if(name MATCHES "^(.*)::([^:]+)$")
    set(space mss::${CMAKE_MATCH_1})
    set(name ${CMAKE_MATCH_2})
  endif()
  set(${result} "namespace ${space} {\n${type} ${name}${rest}\n}" PARENT_SCOPE)
endfunction()
