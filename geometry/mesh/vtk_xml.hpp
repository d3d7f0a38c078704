#pragma once
// VTK's XML files (.vtu, .vti): their pieces and data arrays, ascii, inline binary (base64) or appended (raw or
// base64), plain or compressed by vtkZLibDataCompressor (if the build has zlib). Errors are InputError and name
// the file.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/common/scanner.hpp"

namespace forefeel {

struct XmlTag {
  std::string name;  // "/Piece" for an end
  std::map<std::string, std::string> attributes;
  bool empty = false;  // <Tag/>

  std::string attribute(const std::string& key) const;  // empty where there is none
};
// The next tag but comments and declarations; false at the end. InputError for a damaged tag.
bool next_xml_tag(Scanner& in, XmlTag& tag);

struct VtkXmlArray {
  XmlTag tag;
  std::string_view text;  // between the tags
  std::string attribute(const std::string& key) const { return tag.attribute(key); }
};

struct VtkXmlPiece {
  std::map<std::string, std::string> attributes;
  // By section and name: ["Cells"]["offsets"], ["CellData"]["tissue"]. The array of "Points" is ["Points"][""].
  std::map<std::string, std::map<std::string, VtkXmlArray>> arrays;

  const VtkXmlArray* find(const std::string& section, const std::string& name) const;
};

class VtkXmlReader {
 public:
  VtkXmlReader(Scanner in, std::string type);  // type: "UnstructuredGrid", "ImageData"
  VtkXmlReader(const VtkXmlReader&) = delete;  // has views of its own content
  VtkXmlReader& operator=(const VtkXmlReader&) = delete;
  // Calls `take` for each piece in turn.
  void read(const std::function<void(const VtkXmlPiece&)>& take);

  std::size_t count(const VtkXmlPiece& piece, const char* attribute) const;  // "NumberOfPoints"
  const VtkXmlArray& array(const VtkXmlPiece& piece, const std::string& section,
                           const std::string& name) const;
  std::vector<double> reals(const VtkXmlArray& array) const;  // of type Float32 or Float64
  std::vector<std::int64_t> integers(const VtkXmlArray& array) const;
  const std::string& name() const { return in_.name(); }
  // Of the element <UnstructuredGrid …>, <ImageData …>; known while pieces are read.
  const std::map<std::string, std::string>& attributes() const { return attributes_; }

 private:
  void find_appended();
  void read_root(const XmlTag& tag);
  VtkXmlPiece read_piece(const XmlTag& tag);
  template <class T>
  std::vector<T> values(const VtkXmlArray& array) const;
  template <class T>
  void convert(Scanner& data, const std::string& type, std::vector<T>& result) const;
  std::string bytes_of(const VtkXmlArray& array, const std::string& format) const;
  [[noreturn]] void cut_short() const;
  std::uint64_t header_word(std::string_view bytes, std::size_t i) const;
  std::string head(std::string_view data, bool base64, std::size_t n) const;
  std::string unpack(std::string_view data, bool base64) const;
  void inflate_block(std::string_view packed, std::uint64_t size, std::string& result) const;

  Scanner in_;
  std::string type_;
  std::map<std::string, std::string> attributes_;
  std::string_view appended_;
  bool appended_base64_ = false, compressed_ = false;
  std::size_t header_bytes_ = 4;
};

}  // namespace forefeel
