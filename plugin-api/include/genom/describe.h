/*
 * GENOM_DESCRIPTION("demo.gen"), once in one source file of a codel library, puts the text of
 * the .gen file in the library, as the NUL-terminated string `genom_description`.
 *
 * genomd then needs no other file to run the library. The path is looked for in the compiler's
 * working directory, then along its -I path. Only this file is embedded: what it #includes is
 * looked for, when the library is loaded, beside the library and along the host's include path.
 *
 * The compiler does not list the .gen file among the dependencies it prints (-M): name it as an
 * input of the object file in your build. With -flto, give the -I option to the link as well.
 * ELF systems, gcc and clang, C and C++.
 */
#ifndef GENOM_DESCRIBE_H
#define GENOM_DESCRIBE_H

#ifndef __ELF__
# error "GENOM_DESCRIPTION needs an ELF system; put the .gen file beside the library instead"
#endif

#ifdef __cplusplus
extern "C" {
#endif

extern const char genom_description[] __attribute__((visibility("default")));

#ifdef __cplusplus
}
#endif

/* A section of its own, kept by --gc-sections like the symbol that the host looks up. */
#define GENOM_DESCRIPTION(path) \
  __asm__(".pushsection .rodata.genom_description, \"a\", %progbits\n" \
          ".globl genom_description\n" \
          ".type genom_description, %object\n" \
          "genom_description:\n" \
          ".incbin \"" path "\"\n" \
          ".byte 0\n" \
          ".size genom_description, . - genom_description\n" \
          ".popsection\n"); \
  extern const char genom_description[]

#endif /* GENOM_DESCRIBE_H */
