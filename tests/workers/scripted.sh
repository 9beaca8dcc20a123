#!/bin/sh
# A worker for tests: does what the name of the model says. By the names of links it is broken itself.
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' "${CARGO_MANIFEST_DIR:-.}/Cargo.toml" | head -n 1)
case $0 in
*unborn*) echo 'no such library' >&2; exit 1 ;;
*outdated*) version=0.0.0 ;;
esac
echo "{\"id\":null,\"ready\":{\"version\":\"$version\",\"pid\":$$}}"
fail() {
    echo "{\"id\":$id,\"failed\":{\"kind\":\"$1\",\"message\":\"as told\",\"transient\":$2,\"disk_full\":$3}}"
}
while read -r line; do
    case $line in *'"cancel":'*) continue ;; esac
    id=${line#*\"id\":}; id=${id%%,*}
    model=${line#*\"model\":\"}; model=${model%%\"*}
    name=${model##*/}
    case $name in
    *once*) if [ -e "$model.tried" ]; then name=good.stl; else : > "$model.tried"; fi ;;
    esac
    case $name in
    killed*) kill -9 $$ ;;
    abort*) echo 'stack overflow' >&2; kill -ABRT $$ ;;
    exit*) echo 'out of everything' >&2; exit 7 ;;
    hang*) exec sleep 600 ;;
    eat*) ballast=$(head -c 60000000 /dev/zero | tr '\0' x); read -r never ;;
    nonsense*) echo 'hello' ;;
    broken*) fail model false false ;;
    defect*) fail defect false false ;;
    passing*) fail device true false ;;
    full*) fail output true true ;;
    *) echo "{\"id\":$id,\"done\":{\"layers\":3,\"bytes\":${#name},\"peak_bytes\":9000000}}" ;;
    esac
done
