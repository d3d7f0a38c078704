#pragma once
// No functions here: what is compiled for a newer instruction set must not be shared with other files.

#ifndef FOREFEEL_INLINE
#define FOREFEEL_INLINE inline __attribute__((always_inline))
#endif
