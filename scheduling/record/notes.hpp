#pragma once
// Notes of sessions for people to read. Lines that differ only in their numbers are of one kind: a thousand failed
// solves are one remark. summary.json keeps every line.

#include <span>
#include <string>
#include <vector>

namespace forefeel {

// The notes of one session in their order. Of a kind with more than three lines only the first is kept; it gives the
// number of the others.
std::vector<std::string> shortened_notes(std::span<const std::string> notes);

// The notes of several sessions, one line for each kind, in the order of the first session that has it:
//   3 of 24 cells: policy mine gave priorities …
// sessions: the notes of each one.
std::vector<std::string> notes_in_common(std::span<const std::vector<std::string>> sessions);

}  // namespace forefeel
