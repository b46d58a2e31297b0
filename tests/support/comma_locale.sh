#!/bin/sh
# Runs a command whose tests call setlocale with $UNLATCH_LOCALE, a German locale that is compiled into a temporary folder: decimal
# comma, groups of thousands. Exit code 77 (ctest: skipped) without Debian's package locales.
#   comma_locale.sh COMMAND [ARGUMENT]...
folder=$(mktemp -d) || exit 1
trap 'rm -rf "$folder"' EXIT
if ! localedef -f UTF-8 -i de_DE "$folder/de_DE.UTF-8"; then
  echo "comma_locale.sh: no German locale can be compiled (package locales); not run: $*" >&2
  exit 77
fi
LOCPATH=$folder UNLATCH_LOCALE=de_DE.UTF-8 "$@"
