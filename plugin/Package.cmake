# SPDX-License-Identifier: GPL-2.0-or-later
# The Debian package, which installs beside Debian's own yade:  cd build && cpack  makes talik_<version>_<architecture>.deb
if(NOT TARGET _talik OR YADE_SOURCE_DIR)
	return()
endif()
set(talikPackage lib/python3/dist-packages/talik) # on the search path of /usr/bin/python3, where yade's own package lies
install(TARGETS _talik LIBRARY DESTINATION ${talikPackage})
install(DIRECTORY scripts/talik/ DESTINATION ${talikPackage} FILES_MATCHING PATTERN "*.py" PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY examples/ DESTINATION share/doc/talik/examples FILES_MATCHING PATTERN "*.py" PATTERN "*.csv" PATTERN "*.asc" PATTERN "*.md" PATTERN "*.png" PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY ${CMAKE_BINARY_DIR}/manual/html DESTINATION share/doc/talik OPTIONAL) # once scripts/manual has made it
install(FILES README.md DESTINATION share/doc/talik)
install(FILES LICENSE DESTINATION share/doc/talik RENAME copyright)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_NAME talik)
set(CPACK_PACKAGE_CONTACT "The Talik developers <talik@localhost>")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "thawing and freezing ground at two scales, a plugin for YADE
 A material point method for saturated freezing ground with a periodic sample of
 grains and ice bonds behind every point, loaded by the stock yade: import talik.")
# the binary interface is that of one release; the module checks it again when it is loaded
set(CPACK_DEBIAN_PACKAGE_DEPENDS
	"yade (>= ${yadeVersion}), yade (<< ${yadeVersion}.1), python3-numpy, python3-scipy, python3-matplotlib, python3-shapely, python3-tqdm, python3-vtk9, python3-rasterio, xvfb, libgl1-mesa-dri, libgomp1, libhwy1 | libhwy1t64, libboost-python${Boost_VERSION_STRING}, libboost-serialization${Boost_VERSION_STRING}")
include(CPack)
