# Bash completion for kelly. Commands, options and their words are read from --help: nothing to keep in step.

_kelly()
{
    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} program=${COMP_WORDS[0]} command= help= value=
    COMPREPLY=()
    type -P -- "$program" >/dev/null || return

    # bash splits --option=value at the =
    [ "$word" = "=" ] && word=
    [ "$before" = "=" ] && before=${COMP_WORDS[COMP_CWORD-2]}

    if [ "$COMP_CWORD" -eq 1 ] || { [ "$COMP_CWORD" -eq 2 ] && [ "$before" = help ]; }; then
        local names=$("$program" --help 2>/dev/null | sed -n 's/^  kelly \([a-z][a-z0-9]*\)  .*/\1/p' | sort -u)
        COMPREPLY=($(compgen -W "$names help --help --version" -- "$word"))
        return
    fi

    command=${COMP_WORDS[1]}
    help=$("$program" "$command" --help 2>/dev/null) || return
    if [[ $before == --* ]]; then
        value=$(sed -n "s/^  $before \([^ ]*\) .*/\1/p" <<< "$help")
        case $value in
            F|F.*) compopt -o filenames 2>/dev/null; COMPREPLY=($(compgen -f -- "$word")); return ;;
            *\|*) COMPREPLY=($(compgen -W "${value//|/ }" -- "$word")); return ;;
            ?*) return ;;
        esac
    fi
    # a synopsis that begins with a name takes files
    if [[ $word != -* ]] && [[ $help == *"usage: kelly $command "[a-z]* ]]; then
        compopt -o filenames 2>/dev/null
        COMPREPLY=($(compgen -f -- "$word"))
        return
    fi
    COMPREPLY=($(compgen -W "$(sed -n 's/^  \(--[a-z0-9-]*\).*/\1/p' <<< "$help")" -- "$word"))
}
complete -F _kelly kelly
