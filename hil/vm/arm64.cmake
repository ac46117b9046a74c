# Debian's cross-compiler; arm64 packages are unpacked under LAMELLA_ARM64_ROOT, not installed.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_C_COMPILER aarch64-linux-gnu-gcc)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_LIBRARY_ARCHITECTURE aarch64-linux-gnu)
set(CMAKE_FIND_ROOT_PATH ${LAMELLA_ARM64_ROOT})
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES LAMELLA_ARM64_ROOT)
# Headers that are the architecture's own (OpenSSL's) are found by a compiler that is at home there.
include_directories(SYSTEM ${LAMELLA_ARM64_ROOT}/usr/include/aarch64-linux-gnu)
# The machine's libraries are there for libcamera alone, and whoever loads it.
set(is_program $<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>)
set(loads_plugins $<BOOL:$<TARGET_PROPERTY:LOADS_PLUGINS>>)
if(NOT LAMELLA_ARM64_SHARED)  # as a package's is
  add_link_options($<$<AND:${is_program},$<NOT:${loads_plugins}>>:-static>)
endif()
