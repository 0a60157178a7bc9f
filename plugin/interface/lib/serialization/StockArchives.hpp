// SPDX-License-Identifier: GPL-2.0-or-later
#pragma once
/// How stock classes are archived is compiled into stock YADE: its serializers are used, never made here.
#include <boost/archive/binary_iarchive.hpp>
#include <boost/archive/binary_oarchive.hpp>
#include <boost/archive/detail/iserializer.hpp>
#include <boost/archive/detail/oserializer.hpp>
#include <boost/archive/xml_iarchive.hpp>
#include <boost/archive/xml_oarchive.hpp>
#include <boost/serialization/export.hpp>
#include <boost/serialization/extended_type_info_typeid.hpp>
#include <boost/serialization/singleton.hpp>

#define TALIK_STOCK_SERIALIZER(Class, Kind, Stream)                                                                         \
	extern template class boost::serialization::singleton<boost::archive::detail::Kind<boost::archive::Stream, Class>>; \
	extern template class boost::archive::detail::Kind<boost::archive::Stream, Class>;
#define TALIK_STOCK_POINTER(Class, Kind, Stream) \
	extern template class boost::serialization::singleton<boost::archive::detail::Kind<boost::archive::Stream, Class>>;

/// A stock class that one of ours derives from.
#define TALIK_STOCK_BASE(Class)                                                                                              \
	BOOST_CLASS_EXPORT_KEY(yade::Class)                                                                                  \
	extern template class boost::serialization::singleton<boost::serialization::extended_type_info_typeid<yade::Class>>; \
	TALIK_STOCK_SERIALIZER(yade::Class, iserializer, binary_iarchive)                                                    \
	TALIK_STOCK_SERIALIZER(yade::Class, oserializer, binary_oarchive)                                                    \
	TALIK_STOCK_SERIALIZER(yade::Class, iserializer, xml_iarchive)                                                       \
	TALIK_STOCK_SERIALIZER(yade::Class, oserializer, xml_oarchive)

/// A stock class that one of ours holds by shared_ptr.
#define TALIK_STOCK_HELD(Class)                                                \
	TALIK_STOCK_BASE(Class)                                                \
	TALIK_STOCK_POINTER(yade::Class, pointer_iserializer, binary_iarchive) \
	TALIK_STOCK_POINTER(yade::Class, pointer_oserializer, binary_oarchive) \
	TALIK_STOCK_POINTER(yade::Class, pointer_iserializer, xml_iarchive)    \
	TALIK_STOCK_POINTER(yade::Class, pointer_oserializer, xml_oarchive)
