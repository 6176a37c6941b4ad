/*
 * Conversion of `native` data when a running component is given a new library.
 *
 * `native` data is known to codels only, so after a reload it is what the start codels of the new
 * library made of it. A library that exports, for a native type of its IDS, the function
 *
 *     int genom_convert_COMPONENT_TYPE(const void *old, void **data, const genom_conversion *about)
 *
 * takes over what the library before had. GENOM_CONVERT(COMPONENT_TYPE) writes that line, with the
 * name that the type has in C:
 *
 *     GENOM_CONVERT(demo_handle)
 *     {
 *       const struct demo_handle *before = old;
 *       struct demo_handle *now = *data;
 *
 *       if (!before || before->version != 1) return EINVAL;
 *       now->turns = before->turns;
 *       return 0;
 *     }
 *
 * It is called once for each such member of the IDS, in whatever structs and arrays it is; never for
 * those in sequences, optionals and unions. No codel of either library runs meanwhile, so periods
 * are missed if it takes longer than one. It does not throw, and calls nothing of `self`.
 *
 * `old` is what the library before stored, perhaps NULL. It belongs to that library, whose stop
 * codels free it afterwards: whatever is needed of it must be copied, and nothing may point to it.
 * Functions that it points to are gone soon. How it is laid out is known to the author only: a
 * version as its first member tells.
 *
 * `*data` is what the start codels of this library stored, perhaps NULL: change what it points to, or
 * store another address. What stands there on return, also after a failure, is what the codels of this
 * library get, its stop codels at least.
 *
 * Anything but 0 refuses the reload: the component goes on with its library before, and `old` must be
 * as it was.
 */
#ifndef GENOM_RELOAD_H
#define GENOM_RELOAD_H

#include <stdint.h>

/* Later versions of genomd add members at the end: `size` tells which there are. */
typedef struct genom_conversion {
  uint32_t size;
  const char *instance;    /* name of the component, as `genomctl list` prints it */
  const char *member;      /* path in the IDS of this library, as `arm.tools[2]` */
  const char *old_type;    /* the native type before, as `::demo::handle` */
  const char *old_version; /* `version` of the component before, "0" without one */
  const char *old_digest;  /* digest of the description before */
} genom_conversion;

#ifdef __cplusplus
# define GENOM_RELOAD_C extern "C"
#else
# define GENOM_RELOAD_C
#endif

#define GENOM_CONVERT(type) \
  GENOM_RELOAD_C __attribute__((visibility("default"))) int \
  genom_convert_##type(const void *old, void **data, const genom_conversion *about); \
  int genom_convert_##type(const void *old, void **data, \
    __attribute__((unused)) const genom_conversion *about)

#endif /* GENOM_RELOAD_H */
