# find_package(genomd) gives:
#   genomd::headers                 what codels include
#   genomd_add_component(NAME GEN demo.gen SOURCES a.c b.cc [INCLUDE_DIRECTORIES ...])
#                                   a library NAME.so of codels, with the description beside it
cmake_minimum_required(VERSION 3.20)
get_filename_component(GENOMD_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
find_program(GENOMD_GENOM3 genom3 HINTS "${GENOMD_PREFIX}/bin" REQUIRED)
find_program(GENOMD_GENOMD genomd HINTS "${GENOMD_PREFIX}/bin")
find_program(GENOMD_GENOMCTL genomctl HINTS "${GENOMD_PREFIX}/bin")

if(NOT TARGET genomd::headers)
  add_library(genomd::headers INTERFACE IMPORTED)
  set_target_properties(genomd::headers PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${GENOMD_PREFIX}/include")
endif()

function(genomd_add_component NAME)
  cmake_parse_arguments(PARSE_ARGV 1 ARG "" "GEN" "SOURCES;INCLUDE_DIRECTORIES")
  if(NOT ARG_GEN OR NOT ARG_SOURCES OR ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "write genomd_add_component(NAME GEN file.gen SOURCES file.c ...)")
  endif()
  get_filename_component(gen "${ARG_GEN}" ABSOLUTE)
  set(options)
  foreach(directory IN LISTS ARG_INCLUDE_DIRECTORIES)
    get_filename_component(directory "${directory}" ABSOLUTE)
    list(APPEND options "-I" "${directory}")
  endforeach()

  # The component's name, its header and the packages that it requires.
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${gen}")
  execute_process(COMMAND "${GENOMD_GENOM3}" ${options} genomd/cmake "${gen}"
    OUTPUT_VARIABLE about RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${gen} has errors")
  endif()
  cmake_language(EVAL CODE "${about}")

  set(place "${CMAKE_CURRENT_BINARY_DIR}/genomd/${NAME}")
  set(header "${place}/${GENOMD_HEADER}")
  file(MAKE_DIRECTORY "${place}")
  add_custom_command(OUTPUT "${header}"
    COMMAND "${GENOMD_GENOM3}" ${options} mappings -MD -MF "${header}.d" -MT "${header}"
      --signature -l ${GENOMD_INTERFACE} "${gen}" > "${header}.tmp"
    COMMAND "${CMAKE_COMMAND}" -E copy_if_different "${header}.tmp" "${header}"
    DEPENDS "${gen}" DEPFILE "${header}.d" VERBATIM
    COMMENT "Header ${GENOMD_HEADER}")

  add_library(${NAME} MODULE ${ARG_SOURCES} "${header}")
  set_target_properties(${NAME} PROPERTIES PREFIX "" OUTPUT_NAME "${GENOMD_COMPONENT}")
  target_include_directories(${NAME} PRIVATE
    "${place}" "${CMAKE_CURRENT_SOURCE_DIR}" ${ARG_INCLUDE_DIRECTORIES})
  target_link_libraries(${NAME} PRIVATE genomd::headers)
  # With debug information genomd compares the codels with the description.
  target_compile_options(${NAME} PRIVATE -g -fno-omit-frame-pointer)
  if(GENOMD_REQUIRES)
    find_package(PkgConfig REQUIRED)
    pkg_check_modules(${NAME}_REQUIRES REQUIRED IMPORTED_TARGET ${GENOMD_REQUIRES})
    target_link_libraries(${NAME} PRIVATE PkgConfig::${NAME}_REQUIRES)
  endif()
  foreach(file IN LISTS GENOMD_DESCRIPTIONS)
    get_filename_component(file_name "${file}" NAME)
    if(file STREQUAL gen)
      set(file_name "${GENOMD_COMPONENT}.gen")
    endif()
    add_custom_command(TARGET ${NAME} POST_BUILD VERBATIM
      COMMAND "${CMAKE_COMMAND}" -E copy_if_different "${file}"
        "$<TARGET_FILE_DIR:${NAME}>/${file_name}")
    install(FILES "${file}" DESTINATION lib/genomd RENAME "${file_name}")
  endforeach()
  install(TARGETS ${NAME} DESTINATION lib/genomd)
endfunction()
