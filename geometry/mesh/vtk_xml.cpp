#include "geometry/mesh/vtk_xml.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <type_traits>
#include <utility>

#ifdef FOREFEEL_ZLIB
#include <zlib.h>
#endif

#include "geometry/common/base64.hpp"
#include "geometry/common/error.hpp"
#include "geometry/common/scalar_type.hpp"

namespace forefeel {
namespace {

// Replaces &lt; and similar entities in names.
std::string unescaped(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, char>, 5> entities{
      {{"&amp;", '&'}, {"&lt;", '<'}, {"&gt;", '>'}, {"&quot;", '"'}, {"&apos;", '\''}}};
  std::string out;
  while (!text.empty()) {
    const auto* entity =
        std::ranges::find_if(entities, [&](const auto& e) { return text.starts_with(e.first); });
    out += entity == entities.end() ? text.front() : entity->second;
    text.remove_prefix(entity == entities.end() ? 1 : entity->first.size());
  }
  return out;
}

void parse_tag(const Scanner& in, std::string_view text, XmlTag& tag) {
  tag = {};
  if (!text.empty() && text.back() == '/') tag.empty = true, text.remove_suffix(1);
  const std::size_t name_end = std::min(text.find_first_of(" \t\r\n"), text.size());
  tag.name = std::string(text.substr(0, name_end));
  text.remove_prefix(name_end);
  while (!(text = trimmed(text)).empty()) {
    const std::size_t equals = text.find('=');
    if (equals == std::string_view::npos)
      in.fail(fmt::format("<{:.40}> has an attribute without a value", tag.name));
    const std::string key(trimmed(text.substr(0, equals)));
    text = trimmed(text.substr(equals + 1));
    const std::size_t end = text.empty() ? std::string_view::npos : text.find(text.front(), 1);
    if (text.empty() || (text.front() != '"' && text.front() != '\'') || end == std::string_view::npos)
      in.fail(fmt::format("<{:.40}> has an attribute without quotes", tag.name));
    tag.attributes[key] = unescaped(text.substr(1, end - 1));
    text.remove_prefix(end + 1);
  }
}

std::string decoded(std::string_view text, const Scanner& in) {
  std::optional<std::string> bytes = from_base64(text);
  if (!bytes) in.fail("base64 data hold a character that does not belong there");
  return std::move(*bytes);
}

}  // namespace

std::string XmlTag::attribute(const std::string& key) const {
  const auto found = attributes.find(key);
  return found == attributes.end() ? std::string() : found->second;
}

bool next_xml_tag(Scanner& in, XmlTag& tag) {
  const std::string_view content = in.content();
  for (;;) {
    const std::size_t open = content.find('<', in.position());
    if (open == std::string_view::npos) return false;
    const std::string_view end_mark = content.substr(open, 4) == "<!--" ? "-->" : ">";
    const std::size_t close = content.find(end_mark, open);
    if (close == std::string_view::npos) return false;
    in.seek(close + end_mark.size());
    if (end_mark.size() > 1 || content[open + 1] == '?' || content[open + 1] == '!') continue;
    parse_tag(in, content.substr(open + 1, close - open - 1), tag);
    return true;
  }
}

const VtkXmlArray* VtkXmlPiece::find(const std::string& section, const std::string& name) const {
  const auto part = arrays.find(section);
  if (part == arrays.end()) return nullptr;
  const auto found = part->second.find(name);
  return found == part->second.end() ? nullptr : &found->second;
}

VtkXmlReader::VtkXmlReader(Scanner in, std::string type) : in_(std::move(in)), type_(std::move(type)) {
  find_appended();
}

void VtkXmlReader::read(const std::function<void(const VtkXmlPiece&)>& take) {
  XmlTag tag;
  bool grid = false, closed = false;
  while (!closed && next_xml_tag(in_, tag)) {
    if (tag.name == "VTKFile")
      read_root(tag);
    else if (tag.name == type_) {
      grid = true;
      attributes_ = tag.attributes;
    } else if (tag.name == "Piece" && grid)
      take(read_piece(tag));
    else if (tag.name == "/" + type_)
      closed = true;
  }
  if (!grid)
    throw InputError({.file = in_.name()}, fmt::format("is not a {} file, expected <VTKFile type=\"{}\">",
                                                       type_ == "ImageData" ? "VTI" : "VTU", type_));
  if (!closed)
    throw InputError({.file = in_.name()}, fmt::format("ends before </{}>, the file is cut short", type_));
}

// Appended data may hold any bytes, '<' too: they begin after the '_' that follows <AppendedData …>.
void VtkXmlReader::find_appended() {
  const std::size_t tag = in_.content().find("<AppendedData");
  if (tag == std::string_view::npos) return;
  const std::size_t close = in_.content().find('>', tag), mark = in_.content().find('_', close);
  if (close == std::string_view::npos || mark == std::string_view::npos)
    throw InputError({.file = in_.name()}, "appended data without '_', the file is cut short");
  appended_base64_ = in_.content().substr(tag, close - tag).find("base64") != std::string_view::npos;
  appended_ = in_.content().substr(mark + 1);
}

void VtkXmlReader::read_root(const XmlTag& tag) {
  if (tag.attribute("type") != type_)
    throw InputError({.file = in_.name()},
                     fmt::format("VTKFile of type '{:.40}', expected {}", tag.attribute("type"), type_));
  in_.swap_bytes((tag.attribute("byte_order") == "BigEndian") != (std::endian::native == std::endian::big));
  header_bytes_ = tag.attribute("header_type") == "UInt64" ? 8 : 4;
  const std::string compressor = tag.attribute("compressor");
  compressed_ = !compressor.empty();
  if (compressed_ && compressor != "vtkZLibDataCompressor")
    throw InputError(
        {.file = in_.name()},
        fmt::format("compressor {:.40} is not read, expected vtkZLibDataCompressor or none", compressor));
#ifndef FOREFEEL_ZLIB
  if (compressed_)
    throw InputError({.file = in_.name()},
                     "its data are compressed, expected plain data (this build has no zlib)");
#endif
}

namespace {

bool is_section(const std::string& tag) {
  constexpr std::array sections{"Points", "Cells", "PointData", "CellData",
                                "Verts",  "Lines", "Strips",    "Polys"};
  return std::ranges::find(sections, tag) != sections.end();
}

}  // namespace

VtkXmlPiece VtkXmlReader::read_piece(const XmlTag& start) {
  VtkXmlPiece piece{.attributes = start.attributes, .arrays = {}};
  std::string section;
  XmlTag tag;
  while (!start.empty && next_xml_tag(in_, tag) && tag.name != "/Piece") {
    if (tag.name != "DataArray") {
      if (is_section(tag.name)) section = tag.name;
      continue;
    }
    const std::size_t begin = in_.position();
    std::size_t end = begin;
    if (!tag.empty) {
      end = in_.content().find("</DataArray", begin);
      if (end == std::string_view::npos)
        throw InputError({.file = in_.name()}, "a DataArray has no end, the file is cut short");
      in_.seek(end);
    }
    const std::size_t stop =
        std::min(in_.content().find('<', begin), end);  // before <InformationKey> and the like
    const std::string name = section == "Points" ? std::string() : tag.attributes["Name"];
    piece.arrays[section][name] = {tag, in_.content().substr(begin, stop - begin)};
  }
  return piece;
}

std::size_t VtkXmlReader::count(const VtkXmlPiece& piece, const char* key) const {
  const auto found = piece.attributes.find(key);
  std::int64_t value = 0;
  if (found == piece.attributes.end() || !parse_integer(found->second, value) || value < 0 ||
      value > 0x7fffffff)
    throw InputError({.file = in_.name()}, fmt::format("<Piece> without a count {}", key));
  return static_cast<std::size_t>(value);
}

const VtkXmlArray& VtkXmlReader::array(const VtkXmlPiece& piece, const std::string& section,
                                       const std::string& name) const {
  if (const VtkXmlArray* found = piece.find(section, name)) return *found;
  throw InputError({.file = in_.name()},
                   fmt::format("a piece has no array {}", name.empty() ? section : name));
}

std::vector<double> VtkXmlReader::reals(const VtkXmlArray& array) const {
  return values<double>(array);
}

std::vector<std::int64_t> VtkXmlReader::integers(const VtkXmlArray& array) const {
  return values<std::int64_t>(array);
}

template <class T>
std::vector<T> VtkXmlReader::values(const VtkXmlArray& array) const {
  const std::string format = array.attribute("format"), type = array.attribute("type"),
                    where = in_.name() + ": array " + array.attribute("Name");
  std::vector<T> result;
  if (format.empty() || format == "ascii") {
    Scanner text(std::string(array.text), where);
    while (!text.at_end()) {
      if constexpr (std::is_same_v<T, double>)
        result.push_back(text.real("a number"));
      else
        result.push_back(text.integer("a whole number"));
    }
    return result;
  }
  Scanner data(bytes_of(array, format), where);
  data.swap_bytes(in_.swaps_bytes());
  convert(data, type, result);
  return result;
}

template <class T>
void VtkXmlReader::convert(Scanner& data, const std::string& type, std::vector<T>& result) const {
  constexpr std::array<std::string_view, 10> names{"Int8",   "UInt8", "Int16",  "UInt16",  "Int32",
                                                   "UInt32", "Int64", "UInt64", "Float32", "Float64"};
  const auto* const found = std::ranges::find(names, type);
  if (std::is_same_v<T, double> && !type.starts_with("Float"))
    throw InputError({.file = in_.name()},
                     fmt::format("points of type '{:.40}', expected Float32 or Float64", type));
  if (found == names.end())
    throw InputError({.file = in_.name()}, fmt::format("data of type '{:.40}' are unknown", type));
  with_type(static_cast<Scalar>(found - names.begin()), [&]<class S>(S) {  // in the order of Scalar
    result.reserve(data.remaining() / sizeof(S));
    while (data.remaining() >= sizeof(S)) result.push_back(static_cast<T>(data.raw<S>("a number")));
  });
}

std::string VtkXmlReader::bytes_of(const VtkXmlArray& array, const std::string& format) const {
  const std::string offset = array.attribute("offset");
  if (format == "binary") return unpack(trimmed(array.text), true);
  if (format != "appended")
    throw InputError({.file = in_.name()},
                     fmt::format("data format '{:.40}', expected ascii, binary or appended", format));
  std::int64_t at = 0;
  if (!parse_integer(offset, at) || at < 0 || static_cast<std::size_t>(at) >= appended_.size())
    throw InputError(
        {.file = in_.name()},
        fmt::format("appended data at '{:.40}' lie outside the file, which may be cut short", offset));
  return unpack(appended_.substr(static_cast<std::size_t>(at)), appended_base64_);
}

void VtkXmlReader::cut_short() const {
  throw InputError({.file = in_.name()}, "binary data are cut short");
}

std::uint64_t VtkXmlReader::header_word(std::string_view bytes, std::size_t i) const {
  if ((i + 1) * header_bytes_ > bytes.size()) cut_short();
  if (header_bytes_ == 8) {
    std::uint64_t value;
    std::memcpy(&value, bytes.data() + 8 * i, 8);
    return in_.swaps_bytes() ? byte_swapped(value) : value;
  }
  std::uint32_t value;
  std::memcpy(&value, bytes.data() + 4 * i, 4);
  return in_.swaps_bytes() ? byte_swapped(value) : value;
}

// The first n bytes of data, decoded.
std::string VtkXmlReader::head(std::string_view data, bool base64, std::size_t n) const {
  const std::size_t length = base64 ? base64_length(n) : n;
  if (length > data.size() || n > data.size()) cut_short();
  std::string result = base64 ? decoded(data.substr(0, length), in_) : std::string(data.substr(0, n));
  if (result.size() < n) cut_short();
  result.resize(n);
  return result;
}

std::string VtkXmlReader::unpack(std::string_view data, bool base64) const {
  const std::uint64_t first = header_word(head(data, base64, header_bytes_), 0);
  if (first > data.size()) cut_short();
  if (!compressed_) return head(data, base64, header_bytes_ + first).substr(header_bytes_);
  if (first == 0) return {};
  const std::size_t header_size = header_bytes_ * (3 + first);
  const std::string header = head(data, base64, header_size);
  std::string_view rest = data.substr(base64 ? base64_length(header_size) : header_size);
  std::uint64_t total = 0;
  for (std::size_t b = 0; b < first; ++b) {
    const std::uint64_t size = header_word(header, 3 + b);
    if (size > rest.size() || (total += size) > rest.size()) cut_short();
  }
  const std::string packed = head(rest, base64, total);
  std::string result;
  std::size_t at = 0;
  for (std::size_t b = 0; b < first; ++b) {
    const std::uint64_t last = header_word(header, 2), size = header_word(header, 3 + b);
    inflate_block(std::string_view(packed).substr(at, size),
                  b + 1 == first && last != 0 ? last : header_word(header, 1), result);
    at += size;
  }
  return result;
}

void VtkXmlReader::inflate_block([[maybe_unused]] std::string_view packed,
                                 [[maybe_unused]] std::uint64_t size,
                                 [[maybe_unused]] std::string& result) const {
#ifdef FOREFEEL_ZLIB
  if (size > 1100 * packed.size() + 1100)
    throw InputError({.file = in_.name()}, "compressed data announce more than they can hold");
  const std::size_t start = result.size();
  result.resize(start + size);
  uLongf written = size;
  if (uncompress(reinterpret_cast<Bytef*>(result.data() + start), &written,
                 reinterpret_cast<const Bytef*>(packed.data()), packed.size()) != Z_OK ||
      written != size)
    throw InputError({.file = in_.name()}, "compressed data are damaged");
#endif
}

}  // namespace forefeel
