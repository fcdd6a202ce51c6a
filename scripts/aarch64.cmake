# Cross-compile for 64-bit ARM with Debian's g++-aarch64-linux-gnu; ROOT holds an unpacked arm64 Python with its headers.
set(CMAKE_SYSTEM_NAME Linux)
set(CMAKE_SYSTEM_PROCESSOR aarch64)
set(CMAKE_CXX_COMPILER aarch64-linux-gnu-g++)
set(CMAKE_TRY_COMPILE_PLATFORM_VARIABLES ROOT)
# Python.h includes <aarch64-linux-gnu/python3.11/pyconfig.h>
set(CMAKE_CXX_FLAGS_INIT "-idirafter ${ROOT}/usr/include")
set(Python_INCLUDE_DIR "${ROOT}/usr/include/python3.11")
set(NB_SUFFIX ".cpython-311-aarch64-linux-gnu.so")
