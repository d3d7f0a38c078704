#pragma once
// A mesh in every form that VTK writes.

#include "tests/support/test.hpp"

namespace forefeel::test {

// The files that VTK makes of a legacy file, of which it has read what `holds` says of its `grid` in Python. None, and
// the test counts as skipped, where VTK is not installed.
inline std::vector<fs::path> written_by_vtk(const TemporaryFolder& folder, const std::string& legacy,
                                            const std::string& holds) {
  folder.write("sample.vtk", legacy);
  const auto script = folder.write("write.py", std::string(R"(import sys
try:
    from vtkmodules.vtkIOLegacy import vtkUnstructuredGridReader, vtkUnstructuredGridWriter
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter
except ImportError:
    sys.exit(77)
folder = sys.argv[1]
reader = vtkUnstructuredGridReader()
reader.SetFileName(folder + '/sample.vtk')
reader.ReadAllScalarsOn()
reader.ReadAllFieldsOn()
reader.Update()
grid = reader.GetOutput()
assert )") + holds + R"(
for version in (42, 51):
    for binary in (0, 1):
        w = vtkUnstructuredGridWriter()
        w.SetFileVersion(version)
        (w.SetFileTypeToBinary if binary else w.SetFileTypeToASCII)()
        w.SetFileName('%s/vtk_%d_%d.vtk' % (folder, version, binary))
        w.SetInputData(grid)
        assert w.Write()
for mode in ('Ascii', 'Binary', 'Appended'):
    for compressor in ('None', 'ZLib'):
        for encode in (0, 1):
            for header in (32, 64):
                w = vtkXMLUnstructuredGridWriter()
                getattr(w, 'SetDataModeTo' + mode)()
                getattr(w, 'SetCompressorTypeTo' + compressor)()
                w.SetEncodeAppendedData(encode)
                (w.SetHeaderTypeToUInt32 if header == 32 else w.SetHeaderTypeToUInt64)()
                w.SetFileName('%s/vtk_%s_%s_%d_%d.vtu' % (folder, mode, compressor, encode, header))
                w.SetInputData(grid)
                assert w.Write()
)");
  std::vector<fs::path> files;
  if (python_ran(script.string() + " " + folder.path().string(), "python3-vtk9 is not installed"))
    for (const auto& entry : fs::directory_iterator(folder.path()))
      if (entry.path().filename().string().starts_with("vtk_")) files.push_back(entry.path());
  CHECK((files.empty() || files.size() == 28));
  return files;
}

}  // namespace forefeel::test
