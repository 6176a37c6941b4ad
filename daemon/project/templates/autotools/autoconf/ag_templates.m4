# The option --with-templates=A,B of components: what `genom3 TEMPLATE -C ./TEMPLATE FILE.gen` writes
# for each of them becomes a subdirectory of the build.

# AG_OPT_TEMPLATES(GENOM3, FILE.gen): the option, and the list AG_TEMPLATES_SUBDIRS for Makefile.am.
AC_DEFUN([AG_OPT_TEMPLATES], [
  ag_genom3="$1"
  ag_description="$2"
  AC_ARG_WITH([templates],
    [AS_HELP_STRING([--with-templates=LIST],
      [templates to use, with commas between (`genom3 -l` lists them)])],
    [], [with_templates=no])
  AG_TEMPLATES_SUBDIRS=
  AS_CASE([$with_templates], [no|yes], [],
    [for ag_one in `echo "$with_templates" | tr , ' '`; do
       AS_VAR_APPEND([AG_TEMPLATES_SUBDIRS], [" ./$ag_one"])
     done])
  AC_SUBST([AG_TEMPLATES_SUBDIRS])
])

# AG_OUTPUT_TEMPLATES, after AC_OUTPUT: runs the templates, and their configure script if they have
# one.
AC_DEFUN([AG_OUTPUT_TEMPLATES], [
  for ag_directory in $AG_TEMPLATES_SUBDIRS; do
    ag_one=`echo "$ag_directory" | sed 's,^\./,,'`
    AC_MSG_NOTICE([writing $ag_one])
    $ag_genom3 "$ag_one" -C "$ag_directory" "$ag_description" ||
      AC_MSG_ERROR([genom3 $ag_one failed])
    if test -x "$ag_directory/configure"; then
      (cd "$ag_directory" && ./configure --prefix="$prefix" --srcdir=.) ||
        AC_MSG_ERROR([$ag_directory/configure failed])
    fi
  done
])
